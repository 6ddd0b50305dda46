//! Groups of points of which each knows its side relative to the others'.

/// Disjoint sets whose members carry a sign relative to their root.
#[derive(Debug)]
pub(super) struct Groups {
    parent: Vec<u32>,
    /// Whether the sign differs from the parent's.
    flipped: Vec<bool>,
    size: Vec<u32>,
}

impl Groups {
    pub(super) fn new(count: usize) -> Self {
        Self {
            parent: (0u32..).take(count).collect(),
            flipped: vec![false; count],
            size: vec![1; count],
        }
    }

    /// The root of a member, and whether its sign differs from the root's.
    pub(super) fn find(&mut self, member: u32) -> (u32, bool) {
        let (mut root, mut flipped) = (member, false);
        while self.parent[root as usize] != root {
            flipped ^= self.flipped[root as usize];
            root = self.parent[root as usize];
        }
        // Hang all on the way below the root.
        let (mut at, mut rest) = (member, flipped);
        while self.parent[at as usize] != root && at != root {
            let (next, step) = (self.parent[at as usize], self.flipped[at as usize]);
            self.parent[at as usize] = root;
            self.flipped[at as usize] = rest;
            rest ^= step;
            at = next;
        }
        (root, flipped)
    }

    /// Number of members of a root's group.
    pub(super) fn size(&self, root: u32) -> u32 {
        self.size[root as usize]
    }

    /// Makes one group of those of two members, whose signs differ if `flipped`; false if they are in
    /// one group already.
    pub(super) fn join(&mut self, a: u32, b: u32, flipped: bool) -> bool {
        let ((mut a, a_flipped), (mut b, b_flipped)) = (self.find(a), self.find(b));
        if a == b {
            return false;
        }
        if self.size[a as usize] < self.size[b as usize] {
            std::mem::swap(&mut a, &mut b);
        }
        self.parent[b as usize] = a;
        self.flipped[b as usize] = flipped ^ a_flipped ^ b_flipped;
        self.size[a as usize] += self.size[b as usize];
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::points::index;
    use crate::rng::{Rng, Stage};

    #[test]
    fn relative_signs_match_absolute_ones() {
        let mut rng = Rng::new(3, Stage::Synth, 0);
        let signs: Vec<bool> = (0..200).map(|_| rng.uniform() < 0.5).collect();
        let mut groups = Groups::new(200);
        let mut joins = 0;
        for _ in 0..3000 {
            let [a, b] = [(); 2].map(|()| rng.index(200));
            let differ = signs[a] != signs[b];
            joins += usize::from(groups.join(index(a), index(b), differ));
        }
        assert_eq!(joins, 199);
        let (root, first) = groups.find(0);
        for (i, sign) in signs.iter().enumerate() {
            let (same, flipped) = groups.find(index(i));
            assert_eq!(same, root);
            assert_eq!(flipped != first, *sign != signs[0]);
        }
    }
}
