//! Text and data inside HTML, so that what a file name or comment holds is never taken for markup.

use std::io;

use serde::Serialize;

/// Text for HTML, in elements and in quoted attributes.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // HTML has no place for other control characters.
            c if c.is_control() && !c.is_ascii_whitespace() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// JSON for a script element: in it, `</script>` and `<!--` would end or open something. `<` stands in JSON
/// in strings only, where it can be told by its number.
pub(super) fn json<T: Serialize>(value: &T) -> io::Result<String> {
    let text = serde_json::to_string(value).map_err(io::Error::other)?;
    Ok(text.replace('<', "\\u003c").replace('>', "\\u003e"))
}

/// Writes a page's frame, with what `part` writes in place of each marker, as in `{{title}}`.
pub(super) fn filled<W: io::Write>(
    skeleton: &str,
    out: &mut W,
    mut part: impl FnMut(&str, &mut W) -> io::Result<()>,
) -> io::Result<()> {
    let mut rest = skeleton;
    while let Some((before, behind)) = rest.split_once("{{") {
        out.write_all(before.as_bytes())?;
        let Some((marker, behind)) = behind.split_once("}}") else {
            break;
        };
        part(marker, out)?;
        rest = behind;
    }
    out.write_all(rest.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_text_becomes_text() {
        let text = escaped("<script>alert('a & \"b\"')</script>\u{0}");
        assert_eq!(
            text,
            "&lt;script&gt;alert(&#39;a &amp; &quot;b&quot;&#39;)&lt;/script&gt;\u{fffd}"
        );
    }

    #[test]
    fn json_cannot_end_its_script_and_reads_back() {
        let given = ["</script><!-- ", "a<b>c"];
        let text = json(&given).unwrap();
        assert!(!text.contains(['<', '>']));
        let back: Vec<String> = serde_json::from_str(&text).unwrap();
        assert_eq!(back, given);
    }
}
