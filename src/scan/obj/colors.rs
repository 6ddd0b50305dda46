//! Colours of an OBJ file's materials and textures, sampled at its vertices.

use std::collections::{BTreeMap, BTreeSet};

use super::mtl::{self, Map, Material};
use crate::mesh::Csr;
use crate::scan::paint::{Paint, Painted, Pattern, Placement, WHITE};
use crate::scan::source::Source;
use crate::scan::texture::{Textures, Wrap, rounded};
use crate::scan::texture_coordinates::{float, listed};
use crate::scan::{Column, Scan};

/// No texture coordinate, or no material.
const NONE: u32 = u32::MAX;

/// Images, and lines of material libraries, that are looked at, so that a file cannot keep the reader
/// busy with names; scans in many tiles have hundreds.
const MOST_FILES: usize = 2_000;

/// Libraries of one line.
const MOST_NAMES: usize = 16;

/// Size of all material libraries together, in bytes.
const MOST_TEXT: usize = 64 << 20;

/// What an OBJ file says about the look of its faces.
#[derive(Debug, Default)]
pub(super) struct Surface {
    /// The `vt` lines.
    pub(super) coordinates: Vec<[f64; 2]>,
    /// The texture coordinate of each corner; of the first ones only, if the rest has none.
    corners: Vec<u32>,
    /// What each `mtllib` line names.
    libraries: Vec<String>,
    numbers: BTreeMap<String, u32>,
    /// First face and material of each stretch of faces.
    stretches: Vec<(usize, u32)>,
}

/// What each material looks like, by its number.
#[derive(Debug, Default)]
struct Paints {
    paints: Vec<Paint>,
    /// Whether its image is missing, so that its colour alone would mislead.
    incomplete: Vec<bool>,
    textures: Textures,
}

impl Surface {
    pub(super) fn add_library(&mut self, name: &str) {
        // Some programs repeat the line for every object.
        if self.libraries.len() < MOST_FILES && self.libraries.last().is_none_or(|l| l != name) {
            self.libraries.push(name.to_owned());
        }
    }

    /// The faces from this one on are of that material.
    pub(super) fn use_material(&mut self, name: &str, face: usize) -> Result<(), String> {
        let next = u32::try_from(self.numbers.len()).ok().filter(|n| *n < NONE);
        let next = next.ok_or("there are 2^32 materials or more")?;
        let number = *self.numbers.entry(name.to_owned()).or_insert(next);
        self.stretches.push((face, number));
        Ok(())
    }

    /// The texture coordinate of a corner, which is number `corner` in the file.
    pub(super) fn push_corner(&mut self, coordinate: Option<u32>, corner: usize) {
        if let Some(coordinate) = coordinate {
            self.corners.resize(corner, NONE);
            self.corners.push(coordinate);
        }
    }

    /// #V colours; `None` if the file has no images and no more than one shade of grey.
    ///
    /// A vertex at a seam of the texture gets the mean of the colours on its sides.
    pub(super) fn colors(
        &self,
        faces: &Csr,
        vertices: usize,
        source: &Source,
    ) -> Option<Vec<[u8; 3]>> {
        let name = source.name;
        let known = self.paints(source);
        if !known.are_worth_showing() {
            return None;
        }
        let mut looks = self.looks(faces, vertices);
        looks.sort_unstable();
        looks.dedup();
        let mut colors = vec![rounded(WHITE); vertices];
        let mut unpainted = vertices;
        for of_vertex in looks.chunk_by(|a, b| a.0 == b.0) {
            let mut places: Vec<(u32, Option<[u64; 2]>)> = of_vertex
                .iter()
                .map(|(_, material, coordinate)| {
                    let coordinate = self.coordinates.get(*coordinate as usize);
                    // Bits can be sorted, and give the same coordinate in two lines once.
                    (*material, coordinate.map(|c| c.map(f64::to_bits)))
                })
                .collect();
            places.sort_unstable();
            places.dedup();
            let samples = places.iter().map(|(material, coordinate)| {
                let coordinate = coordinate.map(|c| c.map(f64::from_bits));
                known.color(*material, coordinate)
            });
            let (sum, count) = samples.fold(([0.0; 3], 0.0), |(sum, count), sample| {
                ([0, 1, 2].map(|k| sum[k] + sample[k]), count + 1.0)
            });
            colors[of_vertex[0].0 as usize] = rounded(sum.map(|s| s / count));
            unpainted -= 1;
        }
        if unpainted > 0 {
            log::warn!(
                "{name}: {unpainted} vertices without a face are white, the others textured"
            );
        }
        Some(colors)
    }

    /// For each face the list of its corners' texture coordinates, empty if one has none; `None` if all are.
    pub(super) fn texture_coordinates(&self, faces: &Csr) -> Option<Column> {
        let mut corners = self.corners.iter();
        let mut any = false;
        let lists = faces.rows().map(|face| {
            let place = |corner: Option<&u32>| {
                let place = self.coordinates.get(*corner? as usize)?;
                let is_finite = place.iter().all(|c| float(*c).is_finite());
                is_finite.then_some(*place)
            };
            let places: Vec<Option<[f64; 2]>> =
                face.iter().map(|_| place(corners.next())).collect();
            let places: Option<Vec<[f64; 2]>> = places.into_iter().collect();
            any |= places.is_some();
            listed(&places.unwrap_or_default())
        });
        let lists = lists.collect();
        any.then_some(Column::List(lists))
    }

    /// Vertex, material and texture coordinate of each corner.
    fn looks(&self, faces: &Csr, vertices: usize) -> Vec<(u32, u32, u32)> {
        let mut corners = self.corners.iter().copied();
        let mut looks = Vec::new();
        for (material, face) in self.materials(faces.len()).zip(faces.rows()) {
            for vertex in face {
                let coordinate = corners.next().unwrap_or(NONE);
                if (*vertex as usize) < vertices {
                    looks.push((*vertex, material, coordinate));
                }
            }
        }
        looks
    }

    /// The material of each face.
    fn materials(&self, faces: usize) -> impl Iterator<Item = u32> {
        let mut stretches = self.stretches.iter().peekable();
        let mut material = NONE;
        (0..faces).map(move |number| {
            while let Some((_, next)) = stretches.next_if(|(first, _)| *first <= number) {
                material = *next;
            }
            material
        })
    }

    /// A scan of these faces with their materials.
    pub(super) fn painted(&self, scan: Scan, source: &Source) -> Painted {
        let Paints {
            paints, textures, ..
        } = self.paints(source);
        Painted {
            of_faces: self.materials(scan.faces.len()).collect(),
            scan,
            coordinates: None,
            paints,
            textures,
        }
    }

    fn paints(&self, source: &Source) -> Paints {
        let count = self.numbers.len();
        let mut all = Paints {
            paints: vec![Paint::default(); count],
            incomplete: vec![false; count],
            textures: Textures::default(),
        };
        let mut known = vec![false; count];
        for material in self.load_libraries(source) {
            let Some(number) = self.numbers.get(&material.name) else {
                continue;
            };
            let number = *number as usize;
            if std::mem::replace(&mut known[number], true) {
                continue;
            }
            let paint = &mut all.paints[number];
            paint.diffuse = material.diffuse;
            if let Some(map) = material.map {
                let bytes = || source.load_reference(&map.file);
                let image = all.textures.load(&map.file, source.name, bytes);
                all.incomplete[number] = image.is_none();
                paint.pattern = image.map(|image| pattern(image, &map));
            }
        }
        all
    }

    fn load_libraries(&self, source: &Source) -> Vec<Material> {
        let mut materials = Vec::new();
        if self.stretches.is_empty() {
            return materials;
        }
        let mut seen = BTreeSet::new();
        let mut text = 0;
        for library in self.libraries.iter().filter(|l| seen.insert(l.as_str())) {
            // One name with blanks, or several names.
            let files = match source.load_reference(library) {
                Ok(bytes) => vec![(library.as_str(), Ok(bytes))],
                Err(_) => library
                    .split_whitespace()
                    .take(MOST_NAMES)
                    .map(|file| (file, source.load_reference(file)))
                    .collect(),
            };
            for (file, bytes) in files {
                text += bytes.as_ref().map_or(0, Vec::len);
                let problem = match bytes {
                    Ok(bytes) if text <= MOST_TEXT => {
                        materials.extend(mtl::read(&bytes));
                        continue;
                    }
                    Ok(_) => format!("materials of more than {MOST_TEXT} bytes"),
                    Err(reason) => reason,
                };
                log::warn!(
                    "{}: goes on without the materials of {file}: {problem}",
                    source.name
                );
            }
        }
        materials
    }
}

fn pattern(image: usize, map: &Map) -> Pattern {
    let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
    Pattern {
        image,
        wrap: [wrap; 2],
        placement: Placement::upwards(map.scale, map.offset),
        factor: None,
    }
}

impl Paints {
    /// Whether colours of vertices would tell more than one shade of grey.
    fn are_worth_showing(&self) -> bool {
        let plain = || {
            (self.paints.iter().zip(&self.incomplete))
                .filter(|(_, incomplete)| !**incomplete)
                .filter_map(|(paint, _)| paint.diffuse)
        };
        let bits = |color: [f64; 3]| color.map(f64::to_bits);
        let first = plain().next().map(bits);
        self.paints.iter().any(|paint| paint.pattern.is_some())
            || plain()
                .map(bits)
                .any(|c| c[0] != c[1] || c[1] != c[2] || Some(c) != first)
    }

    /// The colour of a material at a texture coordinate, 0 to 255.
    fn color(&self, material: u32, coordinate: Option<[f64; 2]>) -> [f64; 3] {
        let Some(paint) = self.paints.get(material as usize) else {
            return WHITE;
        };
        (paint.image_color(coordinate, &self.textures)).unwrap_or_else(|| paint.plain_color())
    }
}

#[cfg(test)]
#[cfg(feature = "image")]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scan::{Column, ReadOptions, Scan, obj, read};
    use image::{Rgb, RgbImage};

    const QUAD: &str = "mtllib look.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
                        vt 0.25 0.25\nvt 0.75 0.25\nvt 0.75 0.75\nvt 0.25 0.75\n";

    fn scan(folder: &Path, text: &str) -> Scan {
        let source = Source {
            bytes: text.as_bytes(),
            name: "a.obj",
            folder: Some(folder),
            options: &ReadOptions::default(),
        };
        let scan = obj::read(&source).unwrap();
        scan.check("a.obj").unwrap();
        scan
    }

    /// 2 by 2 pixels, the upper ones black and red, the lower ones green and blue.
    fn folder(materials: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let mut image = RgbImage::new(2, 2);
        image.put_pixel(1, 0, Rgb([255, 0, 0]));
        image.put_pixel(0, 1, Rgb([0, 255, 0]));
        image.put_pixel(1, 1, Rgb([0, 0, 255]));
        image.save(folder.path().join("four colors.png")).unwrap();
        std::fs::write(folder.path().join("look.mtl"), materials).unwrap();
        folder
    }

    fn colors(scan: &Scan) -> Option<Vec<[u8; 3]>> {
        let [r, g, b] = ["red", "green", "blue"].map(|c| match scan.vertices.column(c)? {
            Column::U8(values) => Some(values.clone()),
            _ => None,
        });
        let (r, g, b) = (r?, g?, b?);
        Some((0..r.len()).map(|k| [r[k], g[k], b[k]]).collect())
    }

    const TEXTURED: &str = "newmtl wood\nKd 0.2 0.4 0.6\nmap_Kd -s 1 1 1 Four Colors.PNG\n\
                            newmtl paint\nKd 0.2 0.4 0.6\n";

    #[test]
    fn vertices_get_the_color_of_the_image_at_their_texture_coordinate() {
        let folder = folder(TEXTURED);
        let text = format!("{QUAD}v 9 9 9\nusemtl wood\nf 1/1 2/2 3/3 4/-1\n");
        let colors = colors(&scan(folder.path(), &text)).unwrap();
        let expected = [[0, 255, 0], [0, 0, 255], [255, 0, 0], [0, 0, 0], [255; 3]];
        assert_eq!(colors, expected);
    }

    #[test]
    fn seams_get_the_mean_and_materials_without_an_image_their_color() {
        let folder = folder(TEXTURED);
        let text = format!(
            "{QUAD}vt 0.25 0.25\nusemtl wood\nf 1/1 2/2 3/1\nf 1/5 2/4 3/1\nusemtl paint\nf 1/1 3/1 4/1\n"
        );
        let colors = colors(&scan(folder.path(), &text)).unwrap();
        // Vertex 1: green once, though two lines and three corners say it, and paint.
        assert_eq!(colors[0], [26, 179, 77]);
        assert_eq!(colors[1], [0, 0, 128]);
        assert_eq!(colors[3], [51, 102, 153]);
    }

    #[test]
    fn colors_of_vertices_win_and_grey_alone_is_no_color() {
        let both = folder(TEXTURED);
        let text = "mtllib look.mtl\nv 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\nvt 0 0\n\
                    usemtl wood\nf 1/1 2/1 3/1\n";
        let scan_of_both = scan(both.path(), text);
        assert_eq!(scan_of_both.colors().unwrap(), [[1.0; 3]; 3]);
        let text = format!("{QUAD}usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 4/4\n");
        let grey = folder("newmtl a\nKd .5 .5 .5\nnewmtl b\nKd .5 .5 .5\n");
        assert_eq!(colors(&scan(grey.path(), &text)), None);
        let two = folder("newmtl a\nKd 0 0 0\nnewmtl b\nKd 1 1 1\n");
        let two = colors(&scan(two.path(), &text)).unwrap();
        assert_eq!(two, [[128; 3], [0; 3], [128; 3], [255; 3]]);
    }

    #[test]
    fn what_is_missing_or_broken_leaves_the_scan_without_colors() {
        let text = format!("{QUAD}mtllib none.mtl\nusemtl wood\nf 1/1 2/2 3/99\n");
        for materials in [
            "newmtl wood\nKd 1 0 0\nmap_Kd none.png\n",
            "newmtl wood\nKd 1 0 0\nmap_Kd look.mtl\n",
            "newmtl other\nmap_Kd four colors.png\n",
            "",
        ] {
            let folder = folder(materials);
            assert_eq!(colors(&scan(folder.path(), &text)), None, "{materials}");
        }
    }

    #[test]
    fn real_scans_get_the_colors_that_another_program_sampled() {
        let data = Path::new("../shared/data/transfer");
        let reference = data.join("zebra_rgb.ply");
        if !reference.exists() {
            println!("skipped: no {}", reference.display());
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let text = std::fs::read_to_string(data.join("spot_triangulated.obj")).unwrap();
        let spot = folder.path().join("spot.obj");
        std::fs::write(&spot, format!("mtllib a.mtl\nusemtl a\n{text}")).unwrap();
        let image = std::fs::canonicalize(data.join("spot_texture.png")).unwrap();
        let materials = format!("newmtl a\nmap_Kd {}\n", image.display());
        std::fs::write(folder.path().join("a.mtl"), materials).unwrap();
        for (file, reference) in [
            (data.join("zebra.obj"), reference),
            (spot, data.join("spot_rgb.ply")),
        ] {
            let [ours, theirs] = [&file, &reference].map(|path| {
                let scan = read(path, &ReadOptions::default()).unwrap();
                scan.colors().unwrap()
            });
            assert_eq!(ours.len(), theirs.len());
            let pairs = ours.iter().flatten().zip(theirs.iter().flatten());
            let mut differences: Vec<f64> = pairs.map(|(a, b)| (a - b).abs() * 255.0).collect();
            let mean = differences.iter().sum::<f64>() / differences.len() as f64;
            differences.sort_by(f64::total_cmp);
            let most = differences[differences.len() * 99 / 100];
            println!("{}: mean {mean:.3}, 99 % to {most:.0}", file.display());
            // It took the nearest pixel. Half a pixel off would make the zebra's mean 4.6, and the rows
            // upside down far more.
            assert!(mean < 4.0, "{}: {mean}", file.display());
        }
    }
}
