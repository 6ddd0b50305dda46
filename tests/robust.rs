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

/// The files of a folder of this one, in the order of their names; none if it is not there.
fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(folder);
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("the folder can be listed").path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    files
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).expect("the file can be read")
}

#[test]
fn inputs_that_once_broke_a_reader_do_not_any_more() {
    for (target, format) in TARGETS {
        for path in files(&format!("crashes/{target}")) {
            println!("{}", path.display());
            promises::read(format, &bytes(&path));
        }
    }
}

#[test]
fn inputs_that_once_broke_completion_do_not_any_more() {
    for path in files("crashes/complete") {
        println!("{}", path.display());
        promises::complete(&bytes(&path));
    }
}

#[test]
fn samples_cut_short_and_changed_keep_the_promises() {
    for (target, format) in TARGETS {
        let samples = files(&format!("samples/{target}"));
        assert!(!samples.is_empty(), "there are samples of {target}");
        for path in samples {
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
