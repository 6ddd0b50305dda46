//! In words: which loops are left open, and why.

use std::collections::HashMap;
use std::fmt::Write;

use crate::completion::{CompletionReport, SkippedHole};

/// As many loops of each reason, and as many reasons, are told in words; the JSON has all.
const MOST_TOLD: usize = 10;

/// A sentence for each reason with its loops; `said` comes between them.
pub(super) fn left_open(report: &CompletionReport, said: &str) -> Vec<String> {
    in_words(&report.skipped, said)
}

fn in_words(skipped: &[SkippedHole], said: &str) -> Vec<String> {
    let reasons = by_reason(skipped);
    let mut told: Vec<String> = (reasons.iter().take(MOST_TOLD))
        .map(|(ids, reason)| {
            let first: Vec<String> = ids.iter().take(MOST_TOLD).map(usize::to_string).collect();
            let mut words = format!("loop {}", first.join(", "));
            if ids.len() > MOST_TOLD {
                let _ = write!(words, " and {} more", ids.len() - MOST_TOLD);
            }
            format!("{words}{said}: {reason}")
        })
        .collect();
    let others: usize = (reasons.iter().skip(MOST_TOLD))
        .map(|(ids, _)| ids.len())
        .sum();
    if others > 0 {
        told.push(format!(
            "{others} more{said} for other reasons, which --json tells"
        ));
    }
    told
}

/// The reasons in the order in which they first come, each with its loops.
fn by_reason(skipped: &[SkippedHole]) -> Vec<(Vec<usize>, &str)> {
    let mut reasons: Vec<(Vec<usize>, &str)> = Vec::new();
    let mut places: HashMap<&str, usize> = HashMap::new();
    for hole in skipped {
        let place = *places.entry(&hole.reason).or_insert_with(|| {
            reasons.push((Vec::new(), &hole.reason));
            reasons.len() - 1
        });
        reasons[place].0.extend(&hole.loops);
    }
    reasons
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skipped(id: usize, reason: &str) -> SkippedHole {
        SkippedHole {
            loops: vec![id],
            reason: reason.to_owned(),
        }
    }

    #[test]
    fn loops_with_one_reason_come_together_and_no_more_than_ten_are_told() {
        let mut holes: Vec<SkippedHole> = (0..13).map(|id| skipped(id, "too small")).collect();
        holes.insert(3, skipped(40, "too large"));
        assert_eq!(
            in_words(&holes, " left open"),
            [
                "loop 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and 3 more left open: too small",
                "loop 40 left open: too large"
            ]
        );
        let many: Vec<SkippedHole> = (0..12).map(|id| skipped(id, &format!("as {id}"))).collect();
        let told = in_words(&many, "");
        assert_eq!(told.len(), 11);
        assert_eq!(told[9], "loop 9: as 9");
        assert_eq!(told[10], "2 more for other reasons, which --json tells");
    }
}
