//! Messages as bytes: what they are, their version, the values, and a checksum.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::TileError;

/// Other versions have other layouts, or grow otherwise.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Ends the version.
const END: u8 = b'\n';
const CHECKSUM: usize = size_of::<u32>();

/// A message as bytes.
pub(super) fn sealed<T: Serialize>(kind: &'static str, message: &T) -> Vec<u8> {
    let mut bytes = beginning(kind).into_bytes();
    bytes.extend(VERSION.as_bytes());
    bytes.push(END);
    bytes = postcard::to_extend(message, bytes)
        .expect("vectors grow, and every length is known beforehand");
    let checksum = crc32fast::hash(&bytes);
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// A message from its bytes.
///
/// # Errors
/// [`TileError::Damaged`] if they are not just what was sent; [`TileError::OtherVersion`].
pub(super) fn opened<T: DeserializeOwned>(
    kind: &'static str,
    bytes: &[u8],
) -> Result<T, TileError> {
    let damaged = |reason| TileError::Damaged { kind, reason };
    let Some((sent, checksum)) = bytes.split_last_chunk::<CHECKSUM>() else {
        return Err(damaged("it is too short"));
    };
    let Some(told) = sent.strip_prefix(beginning(kind).as_bytes()) else {
        return Err(damaged("it does not begin as one that relievo has made"));
    };
    if crc32fast::hash(sent) != u32::from_le_bytes(*checksum) {
        return Err(damaged("its checksum is wrong"));
    }
    let end = told.iter().position(|byte| *byte == END);
    let (version, values) = match end.map(|end| (&told[..end], &told[end + 1..])) {
        Some((version, values)) if version.is_ascii() => (version, values),
        _ => return Err(damaged("it does not tell the version of relievo")),
    };
    if version != VERSION.as_bytes() {
        return Err(TileError::OtherVersion {
            kind,
            theirs: String::from_utf8_lossy(version).into_owned(),
            ours: VERSION,
        });
    }
    match postcard::take_from_bytes(values) {
        Ok((message, [])) => Ok(message),
        Ok(_) => Err(damaged("there is more in it than there should be")),
        Err(_) => Err(damaged("its values are not as they should be")),
    }
}

fn beginning(kind: &str) -> String {
    format!("relievo {kind} of version ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_as_they_were_and_nothing_else_does() {
        let message = (3u32, vec![0.25f64, -1.0], Some("word".to_owned()));
        let bytes = sealed("thing", &message);
        assert_eq!(opened("thing", &bytes), Ok(message));
        type Message = (u32, Vec<f64>, Option<String>);
        for end in 0..bytes.len() {
            assert!(opened::<Message>("thing", &bytes[..end]).is_err(), "{end}");
        }
        for place in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[place] ^= 0x10;
            assert!(opened::<Message>("thing", &changed).is_err(), "{place}");
        }
        assert!(opened::<Message>("other", &bytes).is_err());
        // Whole, but something else.
        let other = sealed("thing", &7u8);
        assert!(opened::<Message>("thing", &other).is_err());
        let longer = sealed("thing", &(message_of_nothing(), 5u8));
        assert!(opened::<Message>("thing", &longer).is_err());
    }

    #[test]
    fn messages_of_another_version_are_told_from_damaged_ones() {
        let bytes = sealed("thing", &7u8);
        let (head, rest) = bytes.split_at(beginning("thing").len());
        let mut other = [head, b"9.", rest].concat();
        let sent = other.len() - CHECKSUM;
        let checksum = crc32fast::hash(&other[..sent]);
        other[sent..].copy_from_slice(&checksum.to_le_bytes());
        let error = opened::<u8>("thing", &other).unwrap_err();
        let theirs = format!("9.{VERSION}");
        assert_eq!(
            error,
            TileError::OtherVersion {
                kind: "thing",
                theirs: theirs.clone(),
                ours: VERSION
            }
        );
        let told = error.to_string();
        assert!(
            told.contains(&theirs) && told.contains("same version"),
            "{told}"
        );
    }

    fn message_of_nothing() -> (u32, Vec<f64>, Option<String>) {
        (0, Vec::new(), None)
    }
}
