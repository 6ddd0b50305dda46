//! What fuzzing promises, replayed: small files that other programs wrote, cut short and changed, and
//! inputs that once broke something.

#[path = "fuzz/src/promises.rs"]
#[allow(unreachable_pub, reason = "the fuzz targets are another crate")]
mod promises;

use std::fs;
use std::path::{Path, PathBuf};

use relievo::rng::{Rng, Stage};
use relievo::scan::Format as F;

const TARGETS: [(&str, F); 11] = [
    ("ply", F::Ply),
    ("obj", F::Obj),
    ("off", F::Off),
    ("stl", F::Stl),
    ("xyz", F::Xyz),
    ("ptx", F::Ptx),
    ("pcd", F::Pcd),
    ("e57", F::E57),
    ("las", F::Las),
    ("gltf", F::Gltf),
    ("depth", F::Depth),
];

/// What is in a folder of this one, in the order of the names.
fn entries(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(folder);
    let entries = fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{} cannot be listed: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("the folder can be listed").path())
        .collect();
    paths.sort();
    paths
}

fn files(folder: &str) -> Vec<PathBuf> {
    let mut paths = entries(folder);
    paths.retain(|path| path.is_file());
    assert!(!paths.is_empty(), "{folder} is empty");
    paths
}

/// Inputs that once broke something, by what they broke: there is a folder only for what ever broke.
fn crashes() -> Vec<(String, Vec<PathBuf>)> {
    let name = |path: PathBuf| {
        let name = path.file_name().expect("an entry has a name");
        name.to_string_lossy().into_owned()
    };
    let folders: Vec<String> = entries("crashes").into_iter().map(name).collect();
    assert!(!folders.is_empty(), "there are inputs that broke something");
    let files = |target: String| (target.clone(), files(&format!("crashes/{target}")));
    folders.into_iter().map(files).collect()
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).expect("the file can be read")
}

#[test]
fn inputs_that_once_broke_something_do_not_any_more() {
    for (target, files) in crashes() {
        let format = TARGETS.iter().find(|(name, _)| *name == target);
        assert!(format.is_some() || target == "complete", "{target}");
        for path in files {
            println!("{}", path.display());
            match format {
                Some((_, format)) => promises::read(*format, &bytes(&path)),
                None => promises::complete(&bytes(&path)),
            }
        }
    }
}

#[test]
fn samples_cut_short_and_changed_keep_the_promises() {
    for (target, format) in TARGETS {
        for path in files(&format!("samples/{target}")) {
            println!("{}", path.display());
            let good = bytes(&path);
            promises::read(format, &good);
            let mut rng = Rng::new(7, Stage::Synth, 0);
            for _ in 0..60 {
                let cut = rng.index(good.len());
                promises::read(format, &good[..cut]);
                let mut changed = good.clone();
                for _ in 0..=rng.index(4) {
                    let at = rng.index(changed.len());
                    changed[at] = u8::try_from(rng.index(256)).expect("below 256");
                }
                promises::read(format, &changed);
            }
        }
    }
}

#[test]
fn random_small_meshes_are_completed_or_refused() {
    let mut rng = Rng::new(11, Stage::Synth, 0);
    for _ in 0..150 {
        let length = 20 + rng.index(180);
        let input: Vec<u8> = (0..length)
            .map(|_| u8::try_from(rng.index(256)).expect("below 256"))
            .collect();
        promises::complete(&input);
    }
}
