//! Who uses whom, and the circles in it.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

/// One thing uses another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edge {
    pub from: String,
    pub to: String,
    /// File, line and what stands there.
    pub place: String,
}

/// Edges that lead back to where they began.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Circle(Vec<Edge>);

impl fmt::Display for Circle {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Circle(edges) = self;
        write!(f, "{}", edges[0].from)?;
        edges.iter().try_for_each(|edge| write!(f, " -> {}", edge.to))?;
        edges.iter().try_for_each(|edge| write!(f, "\n    {}", edge.place))
    }
}

/// Circles that have no edge in common, shortest first: without their edges no circle is left.
pub fn circles(edges: impl IntoIterator<Item = Edge>) -> Vec<Circle> {
    let mut graph: BTreeMap<String, Vec<Edge>> = BTreeMap::new();
    for edge in edges.into_iter().filter(|edge| edge.from != edge.to) {
        let known = graph.entry(edge.from.clone()).or_default();
        // One place is enough.
        if known.iter().all(|other| other.to != edge.to) {
            known.push(edge);
        }
    }
    let mut found = Vec::new();
    while let Some(circle) = shortest(&graph) {
        for edge in &circle {
            graph.get_mut(&edge.from).unwrap().retain(|other| other != edge);
        }
        found.push(Circle(circle));
    }
    found
}

fn shortest(graph: &BTreeMap<String, Vec<Edge>>) -> Option<Vec<Edge>> {
    graph.keys().filter_map(|start| way_back(graph, start)).min_by_key(Vec::len)
}

/// The shortest way from a node to itself.
fn way_back(graph: &BTreeMap<String, Vec<Edge>>, start: &str) -> Option<Vec<Edge>> {
    let mut came_by: BTreeMap<&str, &Edge> = BTreeMap::new();
    let mut waiting = VecDeque::from([start]);
    while let Some(node) = waiting.pop_front() {
        for edge in graph.get(node).into_iter().flatten() {
            if !came_by.contains_key(edge.to.as_str()) {
                came_by.insert(&edge.to, edge);
                waiting.push_back(&edge.to);
            }
        }
    }
    let mut way = vec![*came_by.get(start)?];
    while way.last().unwrap().from != start {
        way.push(came_by[way.last().unwrap().from.as_str()]);
    }
    Some(way.into_iter().rev().cloned().collect())
}
