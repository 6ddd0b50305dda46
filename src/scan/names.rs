//! Names of channels, as other formats call them.

/// Most columns or fields that a point can have: more are no scan, and each needs memory of its own.
pub(super) const MOST_COLUMNS: usize = 4096;

/// What other programs call the channels that we know, in lower case.
const SYNONYMS: [(&str, &[&str]); 8] = [
    ("x", &["easting", "pos_x", "points:0", "points_0"]),
    ("y", &["northing", "pos_y", "points:1", "points_1"]),
    ("z", &["elevation", "pos_z", "points:2", "points_2"]),
    ("nx", &["normal_x", "normalx", "normals:0", "normals_0"]),
    ("ny", &["normal_y", "normaly", "normals:1", "normals_1"]),
    ("nz", &["normal_z", "normalz", "normals:2", "normals_2"]),
    ("intensity", &["i", "scalar_intensity"]),
    ("alpha", &["opacity"]),
];

/// Colours that are only told by all three together: `r` alone can be a range.
const COLORS: [[&str; 3]; 2] = [["r", "g", "b"], ["rf", "gf", "bf"]];

/// Names of channels for the names that a file gives to its columns: known ones as in PLY, others
/// kept as far as PLY can (no blanks), each only once.
///
/// Quotes, and units in brackets as in `X[m]`, are taken away. Columns without a name are called
/// after their number, from 1.
pub(super) fn channel_names<'a>(raw: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = raw.into_iter().map(plain_name).collect();
    for name in &mut names {
        let lower = name.to_ascii_lowercase();
        let known = SYNONYMS
            .iter()
            .find(|(known, others)| *known == lower || others.contains(&lower.as_str()));
        if let Some((known, _)) = known {
            (*known).clone_into(name);
        } else if ["red", "green", "blue", "alpha"].contains(&lower.as_str()) {
            *name = lower;
        }
    }
    for short in COLORS {
        let found = short.map(|s| names.iter().position(|n| n.eq_ignore_ascii_case(s)));
        if let [Some(r), Some(g), Some(b)] = found {
            for (index, color) in [(r, "red"), (g, "green"), (b, "blue")] {
                color.clone_into(&mut names[index]);
            }
            break;
        }
    }
    unique(names)
}

/// Lets no two channels have the same name, nor none.
pub(super) fn unique(mut names: Vec<String>) -> Vec<String> {
    let mut taken = std::collections::HashSet::new();
    for (index, name) in names.iter_mut().enumerate() {
        if name.is_empty() {
            *name = format!("column_{}", index + 1);
        }
        if taken.contains(name) {
            // The number of the column keeps this short where a name is repeated a thousand times.
            let mut candidate = format!("{name}_{}", index + 1);
            while taken.contains(&candidate) {
                candidate.push('_');
            }
            *name = candidate;
        }
        taken.insert(name.clone());
    }
    names
}

/// A name without quotes and unit, of the characters that PLY's headers can hold.
pub(super) fn plain_name(raw: &str) -> String {
    /// Longer names come from damaged files only.
    const LONGEST: usize = 64;
    let bare = raw.trim().trim_matches(['"', '\'']).trim();
    let without_unit = bare.find(['[', '(']).map_or(bare, |end| bare[..end].trim());
    let kept = if without_unit.is_empty() {
        bare
    } else {
        without_unit
    };
    kept.chars()
        .take(LONGEST)
        .map(|c| if c.is_ascii_graphic() { c } else { '_' })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_names_become_those_of_ply() {
        for (raw, expected) in [
            ("X,Y,Z,R,G,B", "x,y,z,red,green,blue"),
            ("x,y,z,I,Normal_X", "x,y,z,intensity,nx"),
            ("Easting [m],Northing (m),\"Elevation\"", "x,y,z"),
            (
                "Points:0,Points:1,Points:2,Rf,Gf,Bf",
                "x,y,z,red,green,blue",
            ),
            ("x,y,z,r", "x,y,z,r"),
        ] {
            assert_eq!(channel_names(raw.split(',')).join(","), expected);
        }
    }

    #[test]
    fn other_names_are_kept_apart_and_fit_into_ply() {
        let names = channel_names(["x", "X", "Scalar field", "", "caf\u{e9}", "[m]"]);
        assert_eq!(
            names,
            ["x", "x_2", "Scalar_field", "column_4", "caf_", "[m]"]
        );
    }
}
