//! Loops and orders in directed graphs.

use std::collections::{BTreeMap, BTreeSet};

/// Strongly connected components of the graph whose node `i` has edges to `next[i]`; a component's nodes come in
/// ascending order, components in topological order (edges lead from earlier to later ones), ties by lowest node.
pub(in crate::cosim) fn components(next: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let found = tarjan(next);
    let mut of = vec![0; next.len()];
    for (index, nodes) in found.iter().enumerate() {
        for node in nodes {
            of[*node] = index;
        }
    }
    // Kahn's algorithm over the components, the lowest node first, so that the order depends on nothing else.
    let mut follow = vec![BTreeSet::new(); found.len()];
    let mut pending = vec![0; found.len()];
    for (node, targets) in next.iter().enumerate() {
        for target in targets {
            if of[node] != of[*target] && follow[of[node]].insert(of[*target]) {
                pending[of[*target]] += 1;
            }
        }
    }
    let ready = (0..found.len()).filter(|index| pending[*index] == 0);
    let mut ready: BTreeSet<(usize, usize)> = ready.map(|index| (found[index][0], index)).collect();
    let mut ordered = Vec::with_capacity(found.len());
    while let Some((_, index)) = ready.pop_first() {
        for other in &follow[index] {
            pending[*other] -= 1;
            if pending[*other] == 0 {
                ready.insert((found[*other][0], *other));
            }
        }
        ordered.push(index);
    }
    ordered.into_iter().map(|index| found[index].clone()).collect()
}

/// Does the component have an edge inside?
pub(in crate::cosim) fn is_cyclic(component: &[usize], next: &[Vec<usize>]) -> bool {
    component.len() > 1 || component.first().is_some_and(|node| next[*node].contains(node))
}

/// Tarjan's algorithm, with its own stack: systems may be longer than the thread's.
fn tarjan(next: &[Vec<usize>]) -> Vec<Vec<usize>> {
    const NEW: usize = usize::MAX;
    let (mut index, mut low) = (vec![NEW; next.len()], vec![0; next.len()]);
    let mut on_stack = vec![false; next.len()];
    let (mut stack, mut count, mut found) = (Vec::new(), 0, Vec::new());
    for root in 0..next.len() {
        if index[root] != NEW {
            continue;
        }
        let mut calls = vec![(root, 0)];
        while let Some((node, edge)) = calls.pop() {
            if edge == 0 {
                (index[node], low[node]) = (count, count);
                count += 1;
                stack.push(node);
                on_stack[node] = true;
            }
            match next[node].get(edge) {
                Some(&target) => {
                    calls.push((node, edge + 1));
                    if index[target] == NEW {
                        calls.push((target, 0));
                    } else if on_stack[target] {
                        low[node] = low[node].min(index[target]);
                    }
                }
                None => {
                    if low[node] == index[node] {
                        let at = stack.iter().position(|other| *other == node).unwrap_or(0);
                        let mut nodes = stack.split_off(at);
                        for other in &nodes {
                            on_stack[*other] = false;
                        }
                        nodes.sort_unstable();
                        found.push(nodes);
                    }
                    if let Some((caller, _)) = calls.last() {
                        low[*caller] = low[*caller].min(low[node]);
                    }
                }
            }
        }
    }
    found
}

/// An order of `nodes` that respects the edges `(from, to, weight)` between them as far as loops allow: next always comes
/// the node whose heaviest edge from nodes not yet placed is lightest, ties in the order of `nodes`.
pub(in crate::cosim) fn lightest_first(nodes: &[usize], edges: &[(usize, usize, f64)]) -> Vec<usize> {
    let mut into: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
    for (from, to, weight) in edges.iter().filter(|(from, to, _)| from != to) {
        into.entry(*to).or_default().push((*from, *weight));
    }
    let mut waiting = nodes.to_vec();
    let mut open: BTreeSet<usize> = nodes.iter().copied().collect();
    let mut ordered = Vec::with_capacity(nodes.len());
    while !waiting.is_empty() {
        let mut best = (0, f64::INFINITY);
        for (position, node) in waiting.iter().enumerate() {
            let edges = into.get(node).map_or(&[][..], Vec::as_slice);
            let pending = edges.iter().filter(|(from, _)| open.contains(from));
            let heaviest = pending.map(|(_, weight)| *weight).fold(-1.0, f64::max);
            if heaviest < best.1 {
                best = (position, heaviest);
            }
            if heaviest < 0.0 {
                break;
            }
        }
        let node = waiting.remove(best.0);
        open.remove(&node);
        ordered.push(node);
    }
    ordered
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_come_in_the_order_of_their_edges() {
        // 3 -> {0, 2} loop -> 1; 4 alone, with an edge to itself.
        let next = vec![vec![2], vec![], vec![0, 1], vec![0], vec![4]];
        let found = components(&next);
        assert_eq!(found, [vec![3], vec![0, 2], vec![1], vec![4]]);
        let cyclic: Vec<bool> = found.iter().map(|nodes| is_cyclic(nodes, &next)).collect();
        assert_eq!(cyclic, [false, true, false, true]);
    }

    #[test]
    fn a_loop_is_opened_where_it_is_lightest() {
        let order = lightest_first(&[0, 1, 2], &[(0, 1, 0.5), (1, 0, 1.0), (1, 2, 1.0), (2, 1, 0.5)]);
        assert_eq!(order, [1, 0, 2]);
        assert_eq!(lightest_first(&[0, 1, 2], &[(2, 1, 1.0), (1, 0, 1.0)]), [2, 1, 0]);
    }
}
