//! Sets that grow together.

/// Disjoint sets of the numbers below a count. The lowest member stands for its set, so that the order of the
/// joins does not matter.
#[derive(Debug)]
pub(crate) struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// Each number by itself.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            parents: (0u32..).take(count).collect(),
        }
    }

    /// The lowest member of the set of `member`.
    pub(crate) fn lowest(&mut self, mut member: u32) -> u32 {
        // Halves the path on the way.
        while self.parents[member as usize] != member {
            let above = self.parents[self.parents[member as usize] as usize];
            self.parents[member as usize] = above;
            member = above;
        }
        member
    }

    /// Makes one set of those of two members.
    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.lowest(a), self.lowest(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// For each number the lowest member of its set.
    pub(crate) fn into_lowest(mut self) -> Vec<u32> {
        // Parents are lower than their members, so that theirs are known before.
        for member in 0..self.parents.len() {
            self.parents[member] = self.parents[self.parents[member] as usize];
        }
        self.parents
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_member_stands_for_its_set_in_whatever_order_they_were_joined() {
        let joins = [[7, 3], [5, 9], [3, 9], [1, 8], [4, 4]];
        let mut backwards = joins;
        backwards.reverse();
        for joins in [joins, backwards] {
            let mut sets = DisjointSets::new(10);
            for [a, b] in joins {
                sets.join(a, b);
            }
            assert_eq!(sets.lowest(9), 3);
            assert_eq!(sets.into_lowest(), [0, 1, 2, 3, 4, 3, 6, 3, 1, 3]);
        }
    }
}
