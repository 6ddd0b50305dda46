//! The rows of a PLY file: values off the front of what is left of it, into columns.

use ply_rs::ply::{Encoding, ScalarType};

use super::scalar_column;
use crate::scan::Column;
use crate::scan::channel::{Scalar, match_column};
use crate::scan::text::shown;

/// Why a row could not be read.
pub(super) enum RowError {
    /// The file ends within it.
    End,
    Malformed(String),
}

/// One row, of which the values are taken in order.
pub(super) enum Row<'a, 'b> {
    Text {
        tokens: std::str::SplitAsciiWhitespace<'a>,
        /// Whether the file ends behind this line.
        last: bool,
    },
    Bytes {
        rest: &'b mut &'a [u8],
        big_endian: bool,
    },
}

impl<'a, 'b> Row<'a, 'b> {
    /// The row at the front of `rest`; of text its line is taken off, of bytes what is read.
    pub(super) fn next(encoding: &Encoding, rest: &'b mut &'a [u8]) -> Result<Self, RowError> {
        let big_endian = match encoding {
            Encoding::Ascii => return Self::line(rest),
            Encoding::BinaryLittleEndian => false,
            Encoding::BinaryBigEndian => true,
        };
        Ok(Self::Bytes { rest, big_endian })
    }

    /// The next line that is not blank.
    fn line(rest: &'b mut &'a [u8]) -> Result<Self, RowError> {
        loop {
            let is_end = |b: &u8| matches!(b, b'\n' | b'\r');
            let length = rest.iter().position(is_end).unwrap_or(rest.len());
            let (line, behind) = rest.split_at(length);
            *rest = behind.get(1..).unwrap_or_default();
            if line.trim_ascii().is_empty() {
                if behind.is_empty() {
                    return Err(RowError::End);
                }
                continue;
            }
            let line = std::str::from_utf8(line)
                .map_err(|_| RowError::Malformed("these bytes are not text".to_owned()))?;
            return Ok(Self::Text {
                tokens: line.split_ascii_whitespace(),
                last: rest.is_empty(),
            });
        }
    }

    fn take<T: Scalar>(&mut self) -> Result<T, RowError> {
        match self {
            Self::Bytes { rest, big_endian } => T::take(rest, *big_endian).ok_or(RowError::End),
            Self::Text { tokens, last } => {
                let token = tokens.next().ok_or_else(|| {
                    // A file that was cut off within a line, not a line that is too short.
                    if *last {
                        RowError::End
                    } else {
                        RowError::Malformed("it has too few values".to_owned())
                    }
                })?;
                T::parse(token).ok_or_else(|| {
                    let shown = shown(token);
                    RowError::Malformed(format!("`{shown}` is not a value of its property's type"))
                })
            }
        }
    }

    /// Appends the next value to a column of scalars.
    pub(super) fn value(&mut self, column: &mut Column) -> Result<(), RowError> {
        match_column!(
            column,
            values => values.push(self.take()?),
            _lists => debug_assert!(false, "a scalar's column")
        );
        Ok(())
    }

    /// Appends the next list to a column of lists.
    pub(super) fn list(
        &mut self,
        count: &ScalarType,
        item: &ScalarType,
        column: &mut Column,
    ) -> Result<(), RowError> {
        let length = self.length(count)?;
        // Not reserved: the length is only a claim.
        let mut items = scalar_column(item);
        for _ in 0..length {
            self.value(&mut items)?;
        }
        if let Column::List(lists) = column {
            items.shrink_to_fit();
            lists.push(items);
        }
        Ok(())
    }

    /// The next list as vertex indices, in place of what `out` holds.
    pub(super) fn indices(
        &mut self,
        count: &ScalarType,
        item: &ScalarType,
        out: &mut Vec<u32>,
    ) -> Result<(), RowError> {
        out.clear();
        for _ in 0..self.length(count)? {
            let index = self.integer(item)?.ok_or_else(|| {
                let reason = "its vertex indices are not whole numbers from 0";
                RowError::Malformed(reason.to_owned())
            })?;
            let index = u32::try_from(index)
                .map_err(|_| RowError::Malformed(format!("{index} is not an index")))?;
            out.push(index);
        }
        Ok(())
    }

    fn length(&mut self, count: &ScalarType) -> Result<u32, RowError> {
        if matches!(self, Self::Text { .. }) {
            return self.take();
        }
        let length = self.integer(count)?.ok_or_else(|| {
            let reason = "a list has a length that is not a whole number";
            RowError::Malformed(reason.to_owned())
        })?;
        u32::try_from(length)
            .map_err(|_| RowError::Malformed(format!("a list cannot have {length} items")))
    }

    /// The next value, if its type is one of whole numbers.
    fn integer(&mut self, data_type: &ScalarType) -> Result<Option<i64>, RowError> {
        Ok(Some(match data_type {
            ScalarType::Char => i64::from(self.take::<i8>()?),
            ScalarType::UChar => i64::from(self.take::<u8>()?),
            ScalarType::Short => i64::from(self.take::<i16>()?),
            ScalarType::UShort => i64::from(self.take::<u16>()?),
            ScalarType::Int => i64::from(self.take::<i32>()?),
            ScalarType::UInt => i64::from(self.take::<u32>()?),
            ScalarType::Float | ScalarType::Double => return Ok(None),
        }))
    }

    /// Whether there are values behind those that were taken; only text rows have an end.
    pub(super) fn has_more(&mut self) -> bool {
        match self {
            Self::Text { tokens, .. } => tokens.next().is_some(),
            Self::Bytes { .. } => false,
        }
    }
}
