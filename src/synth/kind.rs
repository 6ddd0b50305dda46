//! The objects by name.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::SynthError;

/// A synthetic object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Square plane with two sine waves crossing at right angles; strictly periodic.
    Waves,
    /// Square plane with Gaussian random relief in a band of wavelengths of 6 to 18 edges.
    Noise,
    /// Golf ball of 21.35 mm radius with 312 dimples.
    GolfBall,
    /// Tree trunk: long ridges with breaks, dark in the grooves. Coloured.
    Bark,
    /// Round column with three rows of eight arched niches.
    Column,
    /// Wall of bricks in running bond with recessed joints. Coloured.
    Bricks,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::Waves,
        Self::Noise,
        Self::GolfBall,
        Self::Bark,
        Self::Column,
        Self::Bricks,
    ];

    /// Its name, as in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Waves => "waves",
            Self::Noise => "noise",
            Self::GolfBall => "golf-ball",
            Self::Bark => "bark",
            Self::Column => "column",
            Self::Bricks => "bricks",
        }
    }

    /// Number of vertices below which the relief is not there at all: at least three for a dimple,
    /// brick or niche, and an interior wide enough for a hole.
    #[must_use]
    pub fn least_vertices(self) -> usize {
        match self {
            Self::Waves | Self::Noise | Self::Bark | Self::Bricks => 500,
            Self::GolfBall | Self::Column => 1000,
        }
    }
}

/// All names, for messages.
pub(super) fn names() -> String {
    Kind::ALL.map(Kind::name).join(", ")
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Kind {
    type Err = SynthError;

    fn from_str(name: &str) -> Result<Self, SynthError> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| SynthError::UnknownKind(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_are_those_of_serde() {
        for kind in Kind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
            assert_eq!(serde_json::to_string(&kind).unwrap(), format!("\"{kind}\""));
        }
        let error = "golfball".parse::<Kind>().unwrap_err();
        assert!(error.to_string().contains("golf-ball"), "{error}");
    }
}
