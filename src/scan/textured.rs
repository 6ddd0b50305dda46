//! Meshes with a texture image: one file or several that go together.

use std::path::{Path, PathBuf};

use super::image::{Image, write_png};
use super::ply::{IMAGE_NUMBER, TEXTURE_FILE};
use super::texture_coordinates::Coordinates;
use super::{Format, OutputFile, Scan, ScanError, WriteOptions, gltf, obj, ply, same_file};

/// A mesh with a texture image, in the making.
///
/// | path | files | image |
/// |---|---|---|
/// | `NAME.ply` | and `NAME.png` | in a comment `TextureFile`; the faces have a list `texcoord` |
/// | `NAME.obj` | and `NAME.mtl`, `NAME.png` | `map_Kd` of the one material |
/// | `NAME.glb` | | embedded |
///
/// Opened before long work as [`OutputFile`] is; the files appear together when they are complete, or none
/// does.
#[derive(Debug)]
pub struct TexturedOutput {
    format: Format,
    mesh: OutputFile,
    library: Option<Beside>,
    image: Option<Beside>,
}

/// A file in the same folder as the mesh.
#[derive(Debug)]
struct Beside {
    /// As the mesh's file calls it.
    name: String,
    output: OutputFile,
}

impl TexturedOutput {
    /// The files that appear beside a mesh of this name, if it is written with a texture image.
    #[must_use]
    pub fn beside(path: &Path) -> Vec<PathBuf> {
        let extensions: &[&str] = match Format::of_path(path) {
            // Standard output has nothing beside it.
            _ if path == Path::new("-") => &[],
            Ok(Format::Ply) => &["png"],
            Ok(Format::Obj) => &["mtl", "png"],
            _ => &[],
        };
        (extensions.iter())
            .map(|extension| path.with_extension(extension))
            .collect()
    }

    /// Opens the outputs. None may be one of the `protected` files (inputs), nor may what is beside the mesh be
    /// there already if the mesh is not: it is somebody else's then.
    ///
    /// # Errors
    /// [`ScanError::TextureToStdout`] for `-`; [`ScanError::NoTextureFormat`]; [`ScanError::UnusableName`];
    /// [`ScanError::WouldOverwrite`]; [`ScanError::Foreign`]; that this build has no images (Cargo feature
    /// `image`); and those of [`OutputFile::create`].
    pub fn create(path: &Path, protected: &[&Path]) -> Result<Self, ScanError> {
        check_built(path)?;
        if path == Path::new("-") {
            return Err(ScanError::TextureToStdout);
        }
        let format = match Format::of_path(path) {
            // glTF is written as GLB, under either name.
            Ok(format @ (Format::Ply | Format::Obj | Format::Gltf)) => format,
            _ => {
                let name = path.display().to_string();
                return Err(ScanError::NoTextureFormat { name });
            }
        };
        let beside = |extension: &str| Beside::create(path, extension, protected);
        Ok(Self {
            format,
            library: (format == Format::Obj).then(|| beside("mtl")).transpose()?,
            image: (format != Format::Gltf)
                .then(|| beside("png"))
                .transpose()?,
            mesh: open(path, protected)?,
        })
    }

    /// The mesh's path, for messages.
    #[must_use]
    pub fn name(&self) -> &str {
        self.mesh.name()
    }

    /// Writes a scan that has texture coordinates ([`Scan::texture_coordinates`]) and its image, and makes all
    /// files appear.
    ///
    /// PLY keeps every channel; `texcoord` is made from coordinates of vertices where it is missing, and an
    /// earlier `TextureFile` is replaced. OBJ and GLB come without colours of vertices, which readers would mix
    /// with the image; GLB with vertices split where texture coordinates differ, the copies behind all others.
    ///
    /// # Errors
    /// [`ScanError::NoTextureCoordinates`]; or [`ScanError::Write`] with what the system says. Nothing is left
    /// then.
    pub fn write(
        mut self,
        scan: &Scan,
        image: &Image,
        options: &WriteOptions,
    ) -> Result<(), ScanError> {
        let missing = || ScanError::NoTextureCoordinates {
            name: self.mesh.name().to_owned(),
        };
        if Coordinates::of(scan).is_none() {
            return Err(missing());
        }
        let written = match (self.format, &mut self.image, &mut self.library) {
            (Format::Obj, Some(_), Some(library)) => {
                obj::write(scan, Some(&library.name), &mut self.mesh)
            }
            (Format::Ply, Some(image), _) => {
                let scan = with_image(scan, &image.name);
                ply::write(&scan, &mut self.mesh, options.ascii)
            }
            _ => {
                let split = scan.split_at_seams().ok_or_else(missing)?;
                let mut png = Vec::new();
                write_png(image, &mut png)
                    .and_then(|()| gltf::write(&split, Some(&png), &mut self.mesh))
            }
        };
        written.map_err(|error| self.mesh.error(error))?;
        let mut outputs = Vec::new();
        if let Some(Beside { name, mut output }) = self.image {
            write_png(image, &mut output).map_err(|error| output.error(error))?;
            if let Some(mut library) = self.library {
                let written = obj::write_library(&name, &mut library.output);
                written.map_err(|error| library.output.error(error))?;
                outputs.push(library.output);
            }
            outputs.push(output);
        }
        // The mesh last: whoever sees it finds what it names.
        outputs.push(self.mesh);
        OutputFile::commit_all(outputs)
    }
}

#[cfg(feature = "image")]
fn check_built(_path: &Path) -> Result<(), ScanError> {
    Ok(())
}

#[cfg(not(feature = "image"))]
fn check_built(path: &Path) -> Result<(), ScanError> {
    Err(ScanError::NoImagesBuiltIn {
        name: path.display().to_string(),
    })
}

impl Beside {
    fn create(mesh: &Path, extension: &str, protected: &[&Path]) -> Result<Self, ScanError> {
        let path: PathBuf = mesh.with_extension(extension);
        let name = path.file_name().and_then(|name| name.to_str());
        let Some(name) = name.filter(|name| !name.contains(char::is_control)) else {
            let name = mesh.display().to_string();
            return Err(ScanError::UnusableName { name });
        };
        let name = name.to_owned();
        let output = open(&path, protected)?;
        if path.exists() && !mesh.exists() {
            return Err(ScanError::Foreign {
                name: path.display().to_string(),
                mesh: mesh.display().to_string(),
            });
        }
        Ok(Self { name, output })
    }
}

fn open(path: &Path, protected: &[&Path]) -> Result<OutputFile, ScanError> {
    let is_input = protected
        .iter()
        .copied()
        .find(|input| same_file(path, input));
    OutputFile::create(path, is_input)
}

/// The scan as PLY with one image keeps it.
fn with_image(scan: &Scan, image: &str) -> Scan {
    let mut scan = scan.with_corner_coordinates().into_owned();
    (scan.comments).retain(|comment| !comment.trim_start().starts_with(TEXTURE_FILE));
    scan.comments.push(format!("{TEXTURE_FILE} {image}"));
    let channels = &mut scan.face_channels.channels;
    channels.retain(|channel| channel.name != IMAGE_NUMBER);
    scan
}

#[cfg(test)]
#[cfg(feature = "image")]
mod tests;
