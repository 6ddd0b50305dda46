//! Where a glTF document keeps its bytes: the binary chunk, data URIs, files beside it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::json::{BufferView, Document};
use crate::scan::source::Source;

/// Files and data URIs that are loaded at most, so that a document cannot keep the reader busy.
const MOST_FILES: usize = 2_000;

/// Memory of all of them, in bytes.
const MOST_MEMORY: usize = 4 << 30;

/// The bytes of each buffer of a document.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    buffers: Vec<&'a [u8]>,
    views: &'a [BufferView],
}

/// The bytes that a document brings from elsewhere, by URI.
pub(super) type Loaded = BTreeMap<String, Vec<u8>>;

/// Loads what the buffers' URIs name.
pub(super) fn load(document: &Document, source: &Source) -> Result<Loaded, String> {
    let mut loaded = Loaded::new();
    let mut memory = 0;
    for (number, buffer) in document.buffers.iter().enumerate() {
        let Some(uri) = &buffer.uri else { continue };
        if loaded.contains_key(uri) {
            continue;
        }
        let bytes = resolve(uri, source)
            .map_err(|reason| format!("its buffer {number} ({}): {reason}", shortened(uri)))?;
        memory += bytes.len();
        if loaded.len() >= MOST_FILES || memory > MOST_MEMORY {
            return Err("its buffers are too many or too large".to_owned());
        }
        loaded.insert(uri.clone(), bytes);
    }
    Ok(loaded)
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        document: &'a Document,
        binary: Option<&'a [u8]>,
        loaded: &'a Loaded,
    ) -> Result<Self, String> {
        let mut buffers = Vec::new();
        for (number, buffer) in document.buffers.iter().enumerate() {
            let bytes = match &buffer.uri {
                Some(uri) => loaded.get(uri).map(Vec::as_slice),
                None => binary.filter(|_| number == 0),
            };
            let bytes = bytes.ok_or_else(|| format!("buffer {number} has no bytes"))?;
            let exact = bytes.get(..buffer.byte_length).ok_or_else(|| {
                let promised = buffer.byte_length;
                let found = bytes.len();
                format!("buffer {number} has {found} bytes instead of {promised}")
            })?;
            buffers.push(exact);
        }
        let views = &document.buffer_views;
        Ok(Self { buffers, views })
    }

    /// Bytes of all buffers together.
    pub(super) fn size(&self) -> usize {
        let sizes = self.buffers.iter().map(|bytes| bytes.len());
        sizes.fold(0, usize::saturating_add)
    }

    /// The bytes of a buffer view, and the step between its elements if it tells one.
    pub(super) fn view(&self, number: usize) -> Result<(&'a [u8], Option<usize>), String> {
        let missing = || format!("there is no buffer view {number}");
        let view = self.views.get(number).ok_or_else(missing)?;
        let buffer = self.buffers.get(view.buffer);
        let bytes = buffer.and_then(|bytes| {
            let end = view.byte_offset.checked_add(view.byte_length)?;
            bytes.get(view.byte_offset..end)
        });
        let bytes = bytes.ok_or_else(|| format!("buffer view {number} exceeds its buffer"))?;
        Ok((bytes, view.byte_stride))
    }
}

/// Whether an extension compresses meshes. Where the document does not require it, it must have the
/// same meshes without it too, and those are read.
pub(super) fn is_compression(extension: &str) -> bool {
    extension.contains("draco") || extension.contains("meshopt")
}

/// Says what to do about a compression.
pub(super) fn compressed(extension: &str) -> String {
    format!(
        "its meshes are compressed ({extension}), which relievo does not read; turn the compression off"
    )
}

/// The bytes that a URI stands for.
pub(super) fn resolve(uri: &str, source: &Source) -> Result<Vec<u8>, String> {
    let Some(data) = uri.strip_prefix("data:") else {
        return source.load_reference(&percent_decoded(uri));
    };
    let (kind, data) = data.split_once(',').ok_or("its data URI has no comma")?;
    if !kind.ends_with(";base64") {
        return Ok(percent_decoded(data).into_owned().into_bytes());
    }
    base64(data).ok_or_else(|| "its data URI is not base64".to_owned())
}

fn shortened(uri: &str) -> String {
    uri.chars().take(60).collect()
}

fn percent_decoded(text: &str) -> Cow<'_, str> {
    if !text.contains('%') {
        return Cow::Borrowed(text);
    }
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, behind @ ..] = rest {
        let code = behind.get(..2).filter(|_| *first == b'%');
        let code = code.and_then(|hex| std::str::from_utf8(hex).ok());
        let code = code.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        bytes.push(code.unwrap_or(*first));
        rest = &behind[if code.is_some() { 2 } else { 0 }..];
    }
    Cow::Owned(String::from_utf8_lossy(&bytes).into_owned())
}

/// RFC 4648, section 4; padding may be missing, blanks are passed over.
fn base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0);
    for symbol in text.trim_end_matches('=').bytes() {
        let value = match symbol {
            b'A'..=b'Z' => symbol - b'A',
            b'a'..=b'z' => symbol - b'a' + 26,
            b'0'..=b'9' => symbol - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'\n' | b'\r' | b' ' => continue,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push(u8::try_from(bits >> count).ok()?);
            bits &= (1 << count) - 1;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_percent_signs_are_decoded() {
        assert_eq!(base64("Zm9vYmE=").unwrap(), b"fooba");
        assert_eq!(base64("Zm9vYg").unwrap(), b"foob");
        assert_eq!(base64("+/8A\n").unwrap(), [0xfb, 0xff, 0]);
        assert_eq!(base64("Zm9*"), None);
        assert_eq!(percent_decoded("a%20b%2"), "a b%2");
        assert_eq!(percent_decoded("%zz%C3%A9%"), "%zzé%");
    }
}
