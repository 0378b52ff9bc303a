//! Rows and columns as the loops over them read them. Over a state whose parts nothing linear couples, what they do not
//! see is left out.

use std::ops::Range;

use super::kernel::{Aligned, WIDTH, aligned};

/// The most slots that columns are added up for at once, so that every load is read once for many: four registers of AVX2
/// for each coordinate.
pub(super) const BLOCK: usize = 2 * WIDTH;

/// Rows over a state, side by side with those that see the same parts of it.
#[derive(Clone, Debug)]
pub struct Rows {
    /// How many they are, and how long.
    pub(super) count: usize,
    pub(super) size: usize,
    pub(super) groups: Vec<Group>,
    /// Row after row of each group.
    pub values: Aligned,
}

/// Up to six rows that see the same parts.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// Which rows they are.
    pub rows: Vec<usize>,
    /// Where in the state they see something, in chunks of [`WIDTH`].
    pub spans: Vec<Range<usize>>,
    /// Length of a row, in the same chunks.
    pub len: usize,
}

impl Rows {
    /// Rows over the parts of a state, given as slots.
    pub fn new(rows: &[Vec<f64>], parts: &[Range<usize>]) -> Self {
        let mut seen: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
        for (index, row) in rows.iter().enumerate() {
            let sees: Vec<usize> = (0..parts.len()).filter(|part| touches(row, &parts[*part])).collect();
            match seen.iter_mut().find(|(other, _)| *other == sees) {
                Some((_, members)) => members.push(index),
                None => seen.push((sees, vec![index])),
            }
        }
        let (mut groups, mut values) = (Vec::new(), Vec::new());
        for (sees, members) in seen {
            let spans = spans(rows[members[0]].len() / 2, sees.iter().map(|part| &parts[*part]));
            let len = spans.iter().map(ExactSizeIterator::len).sum();
            let mut left = &members[..];
            while !left.is_empty() {
                let (now, later) = left.split_at(match left.len() {
                    0..4 => left.len().min(2),
                    4..6 => 4,
                    _ => 6,
                });
                for row in now {
                    values.extend(spans.iter().flat_map(|span| &rows[*row][span.start * WIDTH..span.end * WIDTH]));
                }
                groups.push(Group { rows: now.to_vec(), spans: spans.clone(), len });
                left = later;
            }
        }
        let size = rows.first().map_or(0, Vec::len);
        Self { count: rows.len(), size, groups, values: aligned(&values) }
    }
}

/// Columns over a state, part by part those that touch it.
#[derive(Clone, Debug)]
pub struct Columns {
    pub(super) parts: Vec<Touched>,
    /// Part after part, block after block: of every column first coordinates, then second ones.
    pub values: Aligned,
}

/// A part with the columns that touch it.
#[derive(Clone, Debug)]
pub(super) struct Touched {
    slots: Range<usize>,
    /// Which columns they are.
    pub columns: Vec<usize>,
}

impl Touched {
    /// Its slots in blocks, the last of which may be of [`WIDTH`] slots instead of [`BLOCK`].
    pub fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let end = self.slots.end;
        self.slots.clone().step_by(BLOCK).map(move |at| at..end.min(at + BLOCK))
    }
}

impl Columns {
    /// Columns over the parts of a state, given as slots.
    pub fn new(columns: &[Vec<f64>], parts: &[Range<usize>]) -> Self {
        let mut values = Vec::new();
        let mut touched = Vec::with_capacity(parts.len());
        for part in parts {
            let own: Vec<usize> = (0..columns.len()).filter(|k| touches(&columns[*k], part)).collect();
            let part = Touched { slots: part.clone(), columns: own };
            for block in part.blocks() {
                for column in part.columns.iter().map(|k| &columns[*k]) {
                    for half in column.chunks_exact(column.len() / 2) {
                        values.extend_from_slice(&half[block.clone()]);
                    }
                }
            }
            touched.push(part);
        }
        Self { parts: touched, values: aligned(&values) }
    }

    /// `out += Σ columns[k] p[k]`.
    pub fn add(&self, p: &[f64], out: &mut [f64]) {
        let (x, y) = out.split_at_mut(out.len() / 2);
        let mut values = self.values.iter();
        for part in &self.parts {
            for block in part.blocks() {
                for p in part.columns.iter().map(|k| p[*k]) {
                    for out in [&mut *x, &mut *y].into_iter().flat_map(|half| &mut half[block.clone()]) {
                        *out += values.next().map_or(0.0, |value| value * p);
                    }
                }
            }
        }
    }
}

/// Short columns, as many entries of all of them side by side as are summed at once; the last are padded.
#[derive(Clone, Debug)]
pub struct Panel {
    columns: usize,
    /// [`WIDTH`] entries of column after column, then the next ones.
    pub values: Aligned,
}

impl Panel {
    /// Columns of `len` entries, given one after the other.
    pub fn new(columns: &[f64], len: usize) -> Self {
        let count = columns.len() / len.max(1);
        let mut values = vec![0.0; count * len.next_multiple_of(WIDTH)];
        for (k, column) in columns.chunks_exact(len.max(1)).enumerate() {
            for (chunk, entries) in column.chunks(WIDTH).enumerate() {
                let at = (chunk * count + k) * WIDTH;
                values[at..at + entries.len()].copy_from_slice(entries);
            }
        }
        Self { columns: count, values: aligned(&values) }
    }

    /// An entry of a column.
    pub fn get(&self, column: usize, entry: usize) -> f64 {
        self.values[(entry / WIDTH * self.columns + column) * WIDTH + entry % WIDTH]
    }
}

/// Whether a vector over a state has an entry in a part of it.
fn touches(vector: &[f64], part: &Range<usize>) -> bool {
    let (x, y) = vector.split_at(vector.len() / 2);
    [x, y].iter().any(|half| half[part.clone()].iter().any(|entry| *entry != 0.0))
}

/// Where both coordinates of parts stand in a state of so many slots, in chunks, as few and as long as they can be.
fn spans<'a>(slots: usize, parts: impl Iterator<Item = &'a Range<usize>> + Clone) -> Vec<Range<usize>> {
    let mut spans: Vec<Range<usize>> = Vec::new();
    let second = parts.clone().map(|part| part.start + slots..part.end + slots);
    for part in parts.cloned().chain(second) {
        let chunks = part.start / WIDTH..part.end / WIDTH;
        match spans.last_mut() {
            Some(last) if last.end == chunks.start => last.end = chunks.end,
            _ => spans.push(chunks),
        }
    }
    spans
}
