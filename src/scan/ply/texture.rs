//! Texture images of a PLY file, as MeshLab names them.

use super::header::read_header;
use crate::scan::paint::{Paint, Painted, Pattern, Placement};
use crate::scan::source::Source;
use crate::scan::texture::{Textures, Wrap};
use crate::scan::{Column, Scan, ScanError};

/// Keyword of the comments that name an image each.
pub(in crate::scan) const TEXTURE_FILE: &str = "TextureFile";

/// The faces' number of their image, from 0 in the order of the comments.
pub(in crate::scan) const IMAGE_NUMBER: &str = "texnumber";

/// Reads a PLY file with the images of its faces; `None` if it names none.
pub(in crate::scan) fn read_painted(source: &Source) -> Result<Option<Painted>, ScanError> {
    let (header, _) = read_header(source.bytes, source.name)?;
    let images: Vec<&str> = header.comments.iter().filter_map(|c| image(c)).collect();
    if images.is_empty() {
        return Ok(None);
    }
    let scan = super::read(source.bytes, source.name)?;
    let mut textures = Textures::default();
    let mut paint = |image: &&str| {
        let bytes = || source.load_reference(image);
        let number = textures.load(image, source.name, bytes);
        Paint {
            diffuse: None,
            pattern: number.map(|image| Pattern {
                image,
                wrap: [Wrap::Repeat; 2],
                placement: Placement::upwards([1.0; 2], [0.0; 2]),
                factor: None,
            }),
        }
    };
    let paints = images.iter().map(&mut paint).collect();
    Ok(Some(Painted {
        of_faces: of_faces(&scan),
        scan,
        coordinates: None,
        paints,
        textures,
    }))
}

/// The image that a comment names.
fn image(comment: &str) -> Option<&str> {
    let (keyword, name) = comment.trim().split_once(char::is_whitespace)?;
    (keyword == TEXTURE_FILE).then_some(name.trim())
}

/// The image of each face: the first one, unless the faces have numbers. Other numbers, such as -1, stand for none.
fn of_faces(scan: &Scan) -> Vec<u32> {
    let numbers = scan.face_channels.column(IMAGE_NUMBER);
    let numbers = numbers.filter(|column| !matches!(column, Column::List(_)));
    let number = |face: usize| match numbers {
        None => 0,
        Some(column) => {
            let number = column.get_f64(face);
            let number = number.and_then(|n| crate::scan::vertex_lists::exact_index(n, usize::MAX));
            number.unwrap_or(u32::MAX)
        }
    };
    (0..scan.faces.len()).map(number).collect()
}
