//! Numbers of a glTF document, every offset checked against the bytes that are there.

use super::buffers::Buffers;
use super::json::{Accessor, Sparse};

/// The types of components (*glTF 2.0*, section 3.6.2.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Result<Self, String> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(format!("there is no type of component {code}")),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number in little-endian bytes.
    fn number(self, bytes: &[u8]) -> f64 {
        let byte = |at: usize| bytes.get(at).copied().unwrap_or_default();
        let two = [byte(0), byte(1)];
        let four = [byte(0), byte(1), byte(2), byte(3)];
        match self {
            Self::I8 => i8::from_le_bytes([byte(0)]).into(),
            Self::U8 => byte(0).into(),
            Self::I16 => i16::from_le_bytes(two).into(),
            Self::U16 => u16::from_le_bytes(two).into(),
            Self::U32 => u32::from_le_bytes(four).into(),
            Self::F32 => f32::from_le_bytes(four).into(),
        }
    }

    /// The number that stands for 1 in normalized integers.
    pub(super) fn full(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 => 1.0,
        }
    }
}

/// The numbers of an accessor.
#[derive(Debug)]
pub(super) struct Numbers {
    pub(super) component: Component,
    /// Numbers of an element.
    pub(super) width: usize,
    /// Element by element; normalized integers are fractions already.
    pub(super) values: Vec<f64>,
}

impl Numbers {
    /// The elements, of three numbers each.
    pub(super) fn triples(&self) -> impl Iterator<Item = [f64; 3]> {
        self.values
            .chunks_exact(self.width)
            .map(|v| [0, 1, 2].map(|k| v.get(k).copied().unwrap_or_default()))
    }

    /// Number of elements.
    pub(super) fn len(&self) -> usize {
        self.values.len() / self.width
    }
}

/// Reads an accessor.
pub(super) fn read(
    accessors: &[Accessor],
    number: usize,
    buffers: &Buffers,
) -> Result<Numbers, String> {
    let accessor = accessors.get(number);
    let accessor = accessor.ok_or_else(|| format!("there is no accessor {number}"))?;
    decode(accessor, buffers).map_err(|reason| format!("accessor {number}: {reason}"))
}

fn decode(accessor: &Accessor, buffers: &Buffers) -> Result<Numbers, String> {
    let component = Component::of(accessor.component_type)?;
    let width = match accessor.kind.as_str() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        other => {
            let other: String = other.chars().take(20).collect();
            return Err(format!("elements of the type {other} have no place here"));
        }
    };
    let mut values = if let Some(view) = accessor.buffer_view {
        let run = Run {
            view,
            offset: accessor.byte_offset,
            count: accessor.count,
        };
        run.numbers(component, width, buffers)?
    } else {
        // Zeros cost a file nothing, but memory.
        if accessor.count > buffers.size() {
            return Err(format!("{} elements without data", accessor.count));
        }
        vec![0.0; accessor.count * width]
    };
    if let Some(sparse) = &accessor.sparse {
        overwrite(&mut values, sparse, component, width, buffers)?;
    }
    if accessor.normalized && component != Component::F32 {
        let full = component.full();
        for value in &mut values {
            *value = (*value / full).max(-1.0);
        }
    }
    Ok(Numbers {
        component,
        width,
        values,
    })
}

fn overwrite(
    values: &mut [f64],
    sparse: &Sparse,
    component: Component,
    width: usize,
    buffers: &Buffers,
) -> Result<(), String> {
    let index_type = Component::of(sparse.indices.component_type.unwrap_or_default())?;
    let run = |view, offset| Run {
        view,
        offset,
        count: sparse.count,
    };
    let indices = run(sparse.indices.buffer_view, sparse.indices.byte_offset);
    let indices = indices.numbers(index_type, 1, buffers)?;
    let replacements = run(sparse.values.buffer_view, sparse.values.byte_offset);
    let replacements = replacements.numbers(component, width, buffers)?;
    let elements = values.len() / width;
    for (index, replacement) in indices.iter().zip(replacements.chunks_exact(width)) {
        let index = crate::scan::vertex_lists::exact_index(*index, elements);
        let index = index.ok_or("a sparse index exceeds it")? as usize;
        values[index * width..(index + 1) * width].copy_from_slice(replacement);
    }
    Ok(())
}

/// Elements one after the other in a buffer view.
struct Run {
    view: usize,
    offset: usize,
    count: usize,
}

impl Run {
    fn numbers(
        &self,
        component: Component,
        width: usize,
        buffers: &Buffers,
    ) -> Result<Vec<f64>, String> {
        let (bytes, stride) = buffers.view(self.view)?;
        let size = component.size() * width;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(format!("elements of {size} bytes every {stride} bytes"));
        }
        if self.count == 0 {
            return Ok(Vec::new());
        }
        let end = (self.count - 1)
            .checked_mul(stride)
            .and_then(|n| n.checked_add(size)?.checked_add(self.offset));
        let bytes = end.and_then(|end| bytes.get(self.offset..end));
        let bytes = bytes.ok_or_else(|| {
            let (count, view) = (self.count, self.view);
            format!("{count} elements of {size} bytes exceed buffer view {view}")
        })?;
        let mut values = Vec::with_capacity(self.count * width);
        for element in bytes.chunks(stride) {
            let numbers = element.chunks_exact(component.size()).take(width);
            values.extend(numbers.map(|bytes| component.number(bytes)));
        }
        Ok(values)
    }
}
