//! The header of a PLY file.
//!
//! Lines are cleaned before `ply_rs` sees them: any line ending, blank lines, comments in any
//! encoding, and names that its grammar does not know (`scalar_R_(m)` of `CloudCompare`) or would
//! silently merge (a property that is declared twice shifts every later value).

use ply_rs::parser::{Parser, Reader};
use ply_rs::ply::{DefaultElement, ElementDef, Encoding};

use crate::scan::ScanError;

/// What the header of a PLY file says; counts are as claimed.
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) comments: Vec<String>,
    pub(super) obj_info: Vec<String>,
}

/// One element as declared. `def` has the types and the count, under placeholder names.
pub(super) struct Element {
    pub(super) name: String,
    pub(super) properties: Vec<String>,
    pub(super) def: ElementDef,
}

/// Reads the header and says where the payload starts.
pub(super) fn read_header(bytes: &[u8], name: &str) -> Result<(Header, usize), ScanError> {
    let mut cleaner = Cleaner::default();
    let mut start = 0;
    // The first line tells how lines end; a carriage return alone only counts if there it does, for
    // behind `end_header` a byte 10 may belong to the payload.
    let first = bytes.iter().position(|b| matches!(b, b'\r' | b'\n'));
    let ending = match first.map(|at| (bytes[at], bytes.get(at + 1))) {
        Some((b'\r', next)) if next != Some(&b'\n') => b'\r',
        _ => b'\n',
    };
    loop {
        let rest = &bytes[start..];
        let length = rest.iter().position(|b| *b == ending);
        let line = latin1_or_utf8(&rest[..length.unwrap_or(rest.len())]);
        cleaner.number += 1;
        if cleaner.number == 1 && line.trim_end() != "ply" {
            return Err(cleaner.error(name, &line, "a PLY file begins with the line `ply`"));
        }
        let Some(length) = length else {
            return Err(cleaner.error(name, &line, "the file ends before `end_header`"));
        };
        start += length + 1;
        cleaner
            .add(line.trim())
            .map_err(|reason| cleaner.error(name, &line, reason))?;
        if line.trim() == "end_header" {
            break;
        }
    }
    Ok((cleaner.finish(name)?, start))
}

/// Text of any age: UTF-8, or else Latin-1, which has a character for every byte.
fn latin1_or_utf8(bytes: &[u8]) -> String {
    std::str::from_utf8(bytes).map_or_else(
        |_| bytes.iter().map(|b| char::from(*b)).collect(),
        str::to_owned,
    )
}

#[derive(Default)]
struct Cleaner {
    /// Number of the current line in the file.
    number: usize,
    /// The lines for `ply_rs`.
    clean: String,
    /// Number and text in the file of each line in `clean`.
    origin: Vec<(usize, String)>,
    comments: Vec<String>,
    obj_info: Vec<String>,
    elements: Vec<(String, Vec<String>)>,
}

impl Cleaner {
    fn add(&mut self, line: &str) -> Result<(), &'static str> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let rest = || {
            let rest = line.split_once(char::is_whitespace);
            rest.map_or(String::new(), |(_, rest)| rest.to_owned())
        };
        let clean = match words.as_slice() {
            [] => return Ok(()),
            ["comment", ..] => {
                self.comments.push(rest());
                return Ok(());
            }
            ["obj_info", ..] => {
                self.obj_info.push(rest());
                return Ok(());
            }
            ["element", name, count] => {
                if self.elements.iter().any(|(known, _)| known == name) {
                    return Err("this element is declared twice");
                }
                self.elements.push(((*name).to_owned(), Vec::new()));
                format!("element e{} {count}", self.elements.len() - 1)
            }
            ["property", types @ .., name] => {
                let Some((_, properties)) = self.elements.last_mut() else {
                    return Err("a property belongs behind an element");
                };
                if properties.iter().any(|known| known == name) {
                    return Err("this property is declared twice");
                }
                properties.push((*name).to_owned());
                format!("property {} p{}", types.join(" "), properties.len() - 1)
            }
            ["ply" | "format" | "end_header", ..] => words.join(" "),
            _ => return Err("this is not a line of a PLY header"),
        };
        self.clean.push_str(&clean);
        self.clean.push('\n');
        self.origin.push((self.number, line.to_owned()));
        Ok(())
    }

    fn finish(self, name: &str) -> Result<Header, ScanError> {
        let parser = Parser::<DefaultElement>::new();
        let header = parser
            .read_header(&mut Reader::new(self.clean.as_bytes()))
            .map_err(|e| {
                let known = e
                    .line()
                    .and_then(|line| self.origin.get(line.checked_sub(1)?));
                let (line, text) = known.cloned().unwrap_or((1, "ply".to_owned()));
                let reason = if known.is_some() {
                    "this is not a line of a PLY header; counts are whole numbers from 0".to_owned()
                } else {
                    e.to_string()
                };
                ScanError::Header {
                    name: name.to_owned(),
                    line,
                    text,
                    reason,
                }
            })?;
        let elements = self.elements.into_iter().zip(header.elements.into_values());
        Ok(Header {
            encoding: header.encoding,
            elements: elements
                .map(|((name, properties), def)| Element {
                    name,
                    properties,
                    def,
                })
                .collect(),
            comments: self.comments,
            obj_info: self.obj_info,
        })
    }

    fn error(&self, name: &str, text: &str, reason: &str) -> ScanError {
        ScanError::Header {
            name: name.to_owned(),
            line: self.number,
            text: text.trim().chars().take(80).collect(),
            reason: reason.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(text: &[u8]) -> Result<(Header, usize), String> {
        read_header(text, "a.ply").map_err(|e| e.to_string())
    }

    #[test]
    fn every_line_ending_gives_the_same_header() {
        let text = "ply\nformat ascii 1.0\n\ncomment  two  words \nobj_info num_cols 3\n\
                    element vertex 2\nproperty float x\nproperty list uchar int s_(m)#2\nend_header\n";
        for ending in ["\n", "\r\n", "\r"] {
            let text = text.replace('\n', ending);
            let (header, start) = header(text.as_bytes()).unwrap();
            assert_eq!(start, text.len());
            assert_eq!(header.comments, [" two  words"]);
            assert_eq!(header.obj_info, ["num_cols 3"]);
            assert_eq!(header.elements[0].name, "vertex");
            assert_eq!(header.elements[0].properties, ["x", "s_(m)#2"]);
            assert_eq!(header.elements[0].def.count, 2);
        }
    }

    #[test]
    fn payload_that_begins_like_a_line_end_is_left_alone() {
        for ending in ["\n", "\r\n", "\r"] {
            let text = "ply\nformat binary_little_endian 1.0\nend_header\n".replace('\n', ending);
            let (_, start) = header(format!("{text}\n\r\n").as_bytes()).unwrap();
            assert_eq!(start, text.len(), "{ending:?}");
        }
    }

    #[test]
    fn comments_need_not_be_utf8() {
        let (header, _) =
            header(b"ply\nformat ascii 1.0\ncomment Gr\xfc\xdfe\nend_header\n").unwrap();
        assert_eq!(header.comments, ["Gr\u{fc}\u{df}e"]);
    }

    #[test]
    fn any_white_space_parts_the_words() {
        let text =
            b"ply\nformat ascii 1.0\nelement\x0cvertex 1\nproperty\x0cfloat\x0bx\nend_header\n";
        let (header, _) = header(text).unwrap();
        assert_eq!(header.elements[0].properties, ["x"]);
        assert_eq!(header.elements[0].def.properties.len(), 1);
    }

    #[test]
    fn bad_lines_are_quoted_with_their_number() {
        for (body, number) in [
            ("element vertex -3", 4),
            ("element vertex 99999999999999999999", 4),
            ("element vertex", 4),
            ("property float x", 4),
            ("element a 1\nproperty flout x", 5),
            ("element a 1\nproperty float x\nproperty float x", 6),
            ("element a 1\nelement a 2", 5),
            ("nonsense", 4),
        ] {
            let text = format!("ply\n\nformat ascii 1.0\n{body}\nend_header\n");
            let error = header(text.as_bytes()).map(|_| ()).unwrap_err();
            let bad = body.lines().last().unwrap();
            assert!(
                error.contains(&format!("header line {number} (`{bad}`)")),
                "{error}"
            );
        }
        assert!(header(b"ply\nend_header\n").is_err());
        assert!(header(b"").is_err());
        assert!(header(b"ply\nformat ascii 1.0\n").is_err());
    }
}
