//! Blocks of levels of slaves, and who feeds whom.

use super::graph;
use crate::cosim::system::{Connection, Port, System};
use std::collections::BTreeMap;
use std::ops::Range;

/// Levels in the order in which they step; the slaves of a level do not wait for each other.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::cosim) struct Schedule {
    /// Slaves by level.
    pub levels: Vec<Vec<usize>>,
    /// Of each slave: an input fed from a slave of lower rank has its value at the end of the step.
    pub rank: Vec<usize>,
    /// Levels that step together.
    pub blocks: Vec<Block>,
}

/// Levels that step once, or again and again until they agree.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::cosim) struct Block {
    pub levels: Range<usize>,
    pub iterated: bool,
}

impl Schedule {
    /// Nothing yet; `slaves` is their number.
    pub fn empty(slaves: usize) -> Self {
        Self { levels: Vec::new(), rank: vec![0; slaves], blocks: Vec::new() }
    }

    /// Appends a block of the slaves in `order`: each as early as what it waits for allows.
    pub fn push(&mut self, order: &[usize], connected: &Connected, iterated: bool) {
        let first = self.levels.len();
        let base = self.levels.iter().map(Vec::len).sum::<usize>();
        let mut level = vec![usize::MAX; self.rank.len()];
        for (position, &slave) in order.iter().enumerate() {
            self.rank[slave] = base + position;
            // Those later in the order have no level yet: they are not waited for.
            let waits = connected.before[slave].iter().filter(|before| level[**before] != usize::MAX);
            level[slave] = waits.map(|before| level[*before] + 1).max().unwrap_or(0);
            let at = first + level[slave];
            if self.levels.len() <= at {
                self.levels.push(Vec::new());
            }
            self.levels[at].push(slave);
        }
        self.blocks.push(Block { levels: first..self.levels.len(), iterated });
    }
}

/// Who feeds whom.
#[derive(Debug)]
pub(in crate::cosim) struct Connected {
    /// Slaves fed by each.
    pub after: Vec<Vec<usize>>,
    /// Slaves that feed each.
    pub before: Vec<Vec<usize>>,
    /// From, to, and the fraction of the outputs of `to` that depend on it at once.
    pub edges: Vec<(usize, usize, f64)>,
    /// Slaves sorted by name: ties do not depend on the order in which slaves were added.
    pub by_name: Vec<usize>,
}

impl Connected {
    pub fn new(system: &System) -> Self {
        let count = system.slaves.len();
        let (mut after, mut before) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        let mut edges = Vec::with_capacity(system.connections.len());
        let fractions: Vec<_> = (0..count).map(|slave| system.feed_through(slave)).collect();
        for connection in &system.connections {
            let (from, to) = (connection.from.slave, connection.to.slave);
            after[from].push(to);
            before[to].push(from);
            edges.push((from, to, fractions[to][connection.to.variable]));
        }
        for list in after.iter_mut().chain(&mut before) {
            list.sort_unstable();
            list.dedup();
        }
        let mut by_name: Vec<usize> = (0..count).collect();
        by_name.sort_by_key(|slave| system.slaves[*slave].name());
        Self { after, before, edges, by_name }
    }

    /// Loops and single slaves along the connections, each in the order in which to step it.
    pub fn components(&self) -> Vec<(Vec<usize>, bool)> {
        let mut place = vec![0; self.by_name.len()];
        for (position, slave) in self.by_name.iter().enumerate() {
            place[*slave] = position;
        }
        let named = |slaves: &[usize]| slaves.iter().map(|slave| place[*slave]).collect::<Vec<_>>();
        let next: Vec<Vec<usize>> = self.by_name.iter().map(|slave| named(&self.after[*slave])).collect();
        let mut of = vec![0; place.len()];
        let found = graph::components(&next);
        for (index, component) in found.iter().enumerate() {
            component.iter().for_each(|node| of[*node] = index);
        }
        let mut inside = vec![Vec::new(); found.len()];
        for (from, to, weight) in &self.edges {
            let (from, to) = (place[*from], place[*to]);
            if of[from] == of[to] {
                inside[of[from]].push((from, to, *weight));
            }
        }
        let ordered = found.iter().zip(&inside).map(|(component, edges)| {
            let order = graph::lightest_first(component, edges);
            let slaves = order.into_iter().map(|node| self.by_name[node]).collect();
            (slaves, graph::is_cyclic(component, &next))
        });
        ordered.collect()
    }
}

impl System {
    /// Inputs that depend on themselves at once, through outputs and connections, loop by loop.
    pub fn algebraic_loops(&self) -> Vec<Vec<Port>> {
        let into = |(index, connection): (usize, &Connection)| (connection.to, index);
        let arriving: BTreeMap<Port, usize> = self.connections.iter().enumerate().map(into).collect();
        let mut next = vec![Vec::new(); self.connections.len()];
        for (index, Connection { from: Port { slave, variable }, .. }) in self.connections.iter().enumerate()
        {
            let inputs = |variable| arriving.get(&Port { slave: *slave, variable }).copied();
            match &self.slaves[*slave].variables()[*variable].depends_on {
                Some(on) => {
                    on.iter().filter_map(|input| inputs(*input)).for_each(|before| next[before].push(index))
                }
                None => {
                    let own = Port { slave: *slave, variable: 0 }..Port { slave: slave + 1, variable: 0 };
                    arriving.range(own).for_each(|(_, before)| next[*before].push(index));
                }
            }
        }
        let loops = graph::components(&next).into_iter().filter(|nodes| graph::is_cyclic(nodes, &next));
        loops.map(|nodes| nodes.into_iter().map(|node| self.connections[node].to).collect()).collect()
    }
}

impl Schedule {
    /// Is the slave part of a loop that is repeated?
    pub fn repeats(&self, slave: usize) -> bool {
        let level = self.levels.iter().position(|slaves| slaves.contains(&slave));
        level.is_some_and(|level| {
            self.blocks.iter().any(|block| block.iterated && block.levels.contains(&level))
        })
    }
}
