//! Headers of PCD files, and where they put a point's values.

use crate::scan::names::MOST_COLUMNS;
use crate::scan::{Column, ScanError};

/// How the points are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Storage {
    Ascii,
    Binary,
    Compressed,
}

/// Type of a value: letter and number of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    F32,
    F64,
}

/// A property of the points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Number of its values in each point.
    pub(super) count: usize,
}

/// What a header says.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) fields: Vec<Field>,
    /// Points in a row of the grid; of all, if there is no grid.
    pub(super) width: usize,
    pub(super) height: usize,
    /// Where the sensor stood.
    pub(super) viewpoint: [f64; 3],
    pub(super) storage: Storage,
    /// Where the points begin.
    pub(super) data: usize,
    /// Number of lines of the header.
    pub(super) lines: usize,
}

impl Kind {
    fn of(letter: &str, bytes: &str) -> Option<Self> {
        Some(match (letter, bytes) {
            ("I", "1") => Self::I8,
            ("I", "2") => Self::I16,
            ("I", "4") => Self::I32,
            ("I", "8") => Self::I64,
            ("U", "1") => Self::U8,
            ("U", "2") => Self::U16,
            ("U", "4") => Self::U32,
            ("U", "8") => Self::U64,
            ("F", "4") => Self::F32,
            ("F", "8") => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// A column for such values, empty. 64 bit integers become `double`.
    pub(super) fn column(self) -> Column {
        match self {
            Self::I8 => Column::I8(Vec::new()),
            Self::I16 => Column::I16(Vec::new()),
            Self::I32 => Column::I32(Vec::new()),
            Self::U8 => Column::U8(Vec::new()),
            Self::U16 => Column::U16(Vec::new()),
            Self::U32 => Column::U32(Vec::new()),
            Self::F32 => Column::F32(Vec::new()),
            Self::I64 | Self::U64 | Self::F64 => Column::F64(Vec::new()),
        }
    }
}

impl Header {
    /// Bytes of a point in the binary kinds.
    pub(super) fn point_size(&self) -> usize {
        self.fields.iter().map(|f| f.kind.size() * f.count).sum()
    }

    /// Numbers of a point in the text kind.
    pub(super) fn values(&self) -> usize {
        self.fields.iter().map(|f| f.count).sum()
    }

    pub(super) fn parse(bytes: &[u8], name: &str) -> Result<Self, ScanError> {
        let mut entries = Entries::default();
        let mut at = 0;
        for number in 1.. {
            let rest = &bytes[at..];
            let end = rest.iter().position(|b| *b == b'\n');
            let line = &rest[..end.unwrap_or(rest.len())];
            at += (line.len() + 1).min(rest.len());
            let text = String::from_utf8_lossy(line);
            let fail = |reason: String| ScanError::Header {
                name: name.to_owned(),
                line: number,
                text: text.chars().take(60).collect::<String>().trim().to_owned(),
                reason,
            };
            let storage = entries.line(text.trim()).map_err(fail)?;
            if let Some(storage) = storage {
                return entries.header(storage, at, number).map_err(fail);
            }
            if end.is_none() {
                return Err(fail(
                    "the file ends before a line DATA; it is cut off".to_owned(),
                ));
            }
        }
        // Numbers of lines do not run out before the lines.
        Err(ScanError::NoVertices {
            name: name.to_owned(),
        })
    }
}

/// The entries of a header as far as they are read.
#[derive(Debug, Default)]
struct Entries {
    names: Vec<String>,
    sizes: Vec<String>,
    types: Vec<String>,
    counts: Option<Vec<usize>>,
    width: Option<usize>,
    height: Option<usize>,
    points: Option<usize>,
    viewpoint: [f64; 3],
}

impl Entries {
    /// Reads a line, and gives the storage if it is the last.
    fn line(&mut self, line: &str) -> Result<Option<Storage>, String> {
        let mut words = line.split_whitespace();
        let key = words.next().unwrap_or_default();
        if key.is_empty() || key.starts_with('#') {
            return Ok(None);
        }
        let number = |word: Option<&str>| {
            let parsed = word.and_then(|w| w.parse::<usize>().ok());
            parsed.ok_or_else(|| format!("{key} needs a whole number that is not negative"))
        };
        let mut owned = || words.by_ref().map(str::to_owned).collect::<Vec<_>>();
        match key {
            "VERSION" => {}
            "FIELDS" | "COLUMNS" => self.names = owned(),
            "SIZE" => self.sizes = owned(),
            "TYPE" => self.types = owned(),
            "COUNT" => {
                let counts = words.map(|w| number(Some(w))).collect::<Result<_, _>>()?;
                self.counts = Some(counts);
            }
            "WIDTH" => self.width = Some(number(words.next())?),
            "HEIGHT" => self.height = Some(number(words.next())?),
            "POINTS" => self.points = Some(number(words.next())?),
            "VIEWPOINT" => {
                for value in &mut self.viewpoint {
                    let parsed = words.next().and_then(|w| w.parse::<f64>().ok());
                    *value = parsed
                        .filter(|v| v.is_finite())
                        .ok_or("VIEWPOINT begins with three coordinates")?;
                }
            }
            "DATA" => {
                return match words.next() {
                    Some("ascii") => Ok(Some(Storage::Ascii)),
                    Some("binary") => Ok(Some(Storage::Binary)),
                    Some("binary_compressed") => Ok(Some(Storage::Compressed)),
                    _ => Err("DATA is ascii, binary or binary_compressed".to_owned()),
                };
            }
            _ => return Err("it is not an entry of the header of a PCD file".to_owned()),
        }
        Ok(None)
    }

    fn header(self, storage: Storage, data: usize, lines: usize) -> Result<Header, String> {
        let fields = self.fields()?;
        let (width, height) = match (self.width, self.height, self.points) {
            (Some(width), height, _) => (width, height.unwrap_or(1)),
            (None, _, Some(points)) => (points, 1),
            (None, _, None) => return Err("there is neither WIDTH nor POINTS above".to_owned()),
        };
        let points = width.checked_mul(height);
        if points.is_none() || self.points.is_some_and(|p| Some(p) != points) {
            return Err("WIDTH times HEIGHT is not the number of POINTS".to_owned());
        }
        Ok(Header {
            fields,
            width,
            height,
            viewpoint: self.viewpoint,
            storage,
            data,
            lines,
        })
    }

    fn fields(&self) -> Result<Vec<Field>, String> {
        let counts = self.counts.clone();
        let counts = counts.unwrap_or_else(|| vec![1; self.names.len()]);
        let fields = self.names.len();
        if self.sizes.len() != fields || self.types.len() != fields || counts.len() != fields {
            return Err("SIZE, TYPE and COUNT do not fit to the number of FIELDS".to_owned());
        }
        let values = counts.iter().fold(0_usize, |sum, c| sum.saturating_add(*c));
        if values > MOST_COLUMNS {
            return Err(format!(
                "a point has {values} values, more than the {MOST_COLUMNS} that relievo reads"
            ));
        }
        let types = self.types.iter().zip(&self.sizes);
        types
            .zip(self.names.iter().zip(counts))
            .map(|((letter, size), (name, count))| {
                let kind = Kind::of(letter, size).ok_or_else(|| {
                    format!("TYPE {letter} with SIZE {size} of `{name}` is not known")
                })?;
                Ok(Field {
                    name: name.clone(),
                    kind,
                    count,
                })
            })
            .collect()
    }
}
