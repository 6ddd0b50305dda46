//! Wavefront MTL: the diffuse colour and texture of each material.
//!
//! Reference: *Object Files (.obj)* and *Material Library File (.mtl)*, Wavefront, appendices B1 and
//! B2 of the Advanced Visualizer manual, 1995.

use std::io::{self, Write};

use crate::scan::channel::Scalar;
use crate::scan::text::lines;

/// What a material says about diffuse colour.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Material {
    pub(super) name: String,
    /// `Kd`: intensities, 0 to 1.
    pub(super) diffuse: Option<[f64; 3]>,
    /// `map_Kd`.
    pub(super) map: Option<Map>,
}

/// A texture image, and how its coordinates are changed before they are looked up.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Map {
    /// Name of the file, as in the library.
    pub(super) file: String,
    /// `-s`: factors of u and v.
    pub(super) scale: [f64; 2],
    /// `-o`: added to u and v after that.
    pub(super) offset: [f64; 2],
    /// `-clamp on`: the image is not repeated.
    pub(super) clamp: bool,
}

/// Options of maps and their number of values; those of numbers may have fewer.
const OPTIONS: [(&str, usize, bool); 13] = [
    ("-blendu", 1, false),
    ("-blendv", 1, false),
    ("-boost", 1, true),
    ("-bm", 1, true),
    ("-cc", 1, false),
    ("-clamp", 1, false),
    ("-imfchan", 1, false),
    ("-mm", 2, true),
    ("-o", 3, true),
    ("-s", 3, true),
    ("-t", 3, true),
    ("-texres", 1, true),
    ("-type", 1, false),
];

/// Name of the material of [`write`].
pub(super) const TEXTURE: &str = "texture";

/// Writes a library of one material with a texture image.
pub(in crate::scan) fn write(image: &str, out: &mut impl Write) -> io::Result<()> {
    // White, since the colour is multiplied with the image; no highlights.
    write!(
        out,
        "newmtl {TEXTURE}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {image}\n"
    )
}

/// The materials of a library, in its order. Lines that cannot be understood are passed over: a
/// missing colour is no reason to refuse a scan.
pub(super) fn read(bytes: &[u8]) -> Vec<Material> {
    let mut materials: Vec<Material> = Vec::new();
    for (_, line) in lines(bytes) {
        let (keyword, rest) = split_word(&line);
        if keyword == "newmtl" {
            materials.push(Material {
                name: rest.to_owned(),
                ..Material::default()
            });
        }
        let Some(material) = materials.last_mut() else {
            continue;
        };
        match keyword.to_ascii_lowercase().as_str() {
            "kd" => material.diffuse = color(rest),
            "map_kd" => material.map = map(rest),
            _ => {}
        }
    }
    materials
}

/// The first word, and what follows it without blanks around.
pub(super) fn split_word(text: &str) -> (&str, &str) {
    let text = text.trim();
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim())
}

/// `r g b`, or `r` for all three.
fn color(text: &str) -> Option<[f64; 3]> {
    let mut values = text
        .split_whitespace()
        .map_while(|token| f64::parse(token).filter(|v| v.is_finite()));
    let red = values.next()?;
    let rest = values.next().zip(values.next());
    let (green, blue) = rest.unwrap_or((red, red));
    Some([red, green, blue].map(|v| v.clamp(0.0, 1.0)))
}

fn map(text: &str) -> Option<Map> {
    let mut map = Map {
        file: String::new(),
        scale: [1.0; 2],
        offset: [0.0; 2],
        clamp: false,
    };
    let mut rest = text;
    loop {
        let (word, behind) = split_word(rest);
        let lower = word.to_ascii_lowercase();
        let Some((option, most, numbers)) = OPTIONS.iter().find(|(name, ..)| *name == lower) else {
            break;
        };
        rest = behind;
        let mut values = Vec::new();
        for _ in 0..*most {
            let (value, behind) = split_word(rest);
            let number = f64::parse(value).filter(|v| v.is_finite());
            // The last word is the name of the file, even if it reads as a number.
            if behind.is_empty() || (*numbers && number.is_none()) {
                break;
            }
            map.clamp |= *option == "-clamp" && value.eq_ignore_ascii_case("on");
            values.extend(number);
            rest = behind;
        }
        match *option {
            "-s" => copy(&values, &mut map.scale),
            "-o" => copy(&values, &mut map.offset),
            _ => {}
        }
    }
    rest.clone_into(&mut map.file);
    (!map.file.is_empty()).then_some(map)
}

fn copy(values: &[f64], into: &mut [f64; 2]) {
    for (into, value) in into.iter_mut().zip(values) {
        *into = *value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(line: &str) -> Option<Map> {
        let text = format!("newmtl a\nmap_Kd {line}\n");
        read(text.as_bytes()).pop().unwrap().map
    }

    #[test]
    fn materials_have_a_color_and_an_image() {
        let text = "# made by hand\nKd 1 1 1\nnewmtl Material #25\n\tKd 0.5 0.25 2\n\
                    newmtl b c\r\nKd 0.5\nKa 1 0 0\nmap_Kd wood.png\nnewmtl d\nKd spectral x.rfl\n";
        let materials = read(text.as_bytes());
        let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["Material #25", "b c", "d"]);
        assert_eq!(materials[0].diffuse, Some([0.5, 0.25, 1.0]));
        assert_eq!(materials[1].diffuse, Some([0.5; 3]));
        assert_eq!(materials[1].map.as_ref().unwrap().file, "wood.png");
        assert_eq!(materials[2].diffuse, None);
    }

    #[test]
    fn options_come_before_the_name_which_may_have_blanks() {
        let plain = file("my wood.png").unwrap();
        assert_eq!(plain.file, "my wood.png");
        let map = file("-s 2 3 1 -o .5 -clamp on -mm 0 1 -type sphere a  b.png").unwrap();
        assert_eq!(map.file, "a  b.png");
        assert_eq!((map.scale, map.offset), ([2.0, 3.0], [0.5, 0.0]));
        assert!(map.clamp && !plain.clamp);
        assert_eq!(file("-s 1 1 2").unwrap().file, "2");
        assert_eq!(file("-file.png").unwrap().file, "-file.png");
        assert_eq!(file(""), None);
    }
}
