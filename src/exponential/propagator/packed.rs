//! Memory layout of rows and columns for the kernels. Parts of the state on which a row or column is zero are omitted.

use std::ops::Range;

use aligned_vec::{AVec, ConstAlign};

use crate::linalg::LANES;

/// Numbers that begin at a cache line: otherwise half of all vector loads would cross a line.
pub type Aligned = AVec<f64, ConstAlign<CACHE_LINE_BYTES>>;
/// Size of a cache line, bytes.
const CACHE_LINE_BYTES: usize = 64;

/// Copies numbers to the beginning of a cache line.
pub fn aligned(values: &[f64]) -> Aligned {
    Aligned::from_slice(CACHE_LINE_BYTES, values)
}

/// Slots for which columns are summed in one pass: four registers of AVX2 for each coordinate. Every load is then read
/// once for all these slots.
pub(in crate::exponential) const BLOCK_SLOTS: usize = 2 * LANES;

/// Rows over a state, grouped by the parts of the state on which they are not zero.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Number of rows.
    pub(in crate::exponential) count: usize,
    /// Length of the state.
    pub(in crate::exponential) size: usize,
    pub(in crate::exponential) groups: Vec<Group>,
    /// Entries of each group, row after row.
    pub values: Aligned,
}

/// Up to six rows that are not zero on the same parts.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct Group {
    /// Indices of the rows.
    pub rows: Vec<usize>,
    /// Ranges of the state that the rows contain, in chunks of [`LANES`].
    pub spans: Vec<Range<usize>>,
    /// Length of a row without its zero parts, in chunks.
    pub len: usize,
}

impl Rows {
    /// Packs rows over the parts of a state, which are ranges of slots.
    pub fn new(rows: &[Vec<f64>], parts: &[Range<usize>]) -> Self {
        let mut by_parts: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
        for (index, row) in rows.iter().enumerate() {
            let own: Vec<usize> = (0..parts.len()).filter(|part| is_nonzero_on(row, &parts[*part])).collect();
            match by_parts.iter_mut().find(|(parts, _)| *parts == own) {
                Some((_, members)) => members.push(index),
                None => by_parts.push((own, vec![index])),
            }
        }
        let (mut groups, mut values) = (Vec::new(), Vec::new());
        for (own, members) in by_parts {
            let spans = spans(rows[members[0]].len() / 2, own.iter().map(|part| &parts[*part]));
            let len = spans.iter().map(ExactSizeIterator::len).sum();
            let mut left = &members[..];
            while !left.is_empty() {
                let (group, rest) = left.split_at(match left.len() {
                    0..4 => left.len().min(2),
                    4..6 => 4,
                    _ => 6,
                });
                for row in group {
                    values.extend(spans.iter().flat_map(|span| &rows[*row][span.start * LANES..span.end * LANES]));
                }
                groups.push(Group { rows: group.to_vec(), spans: spans.clone(), len });
                left = rest;
            }
        }
        let size = rows.first().map_or(0, Vec::len);
        Self { count: rows.len(), size, groups, values: aligned(&values) }
    }
}

/// Columns over a state: for each part the columns that are not zero on it.
#[derive(Clone, Debug)]
pub struct Columns {
    pub(in crate::exponential) parts: Vec<NonzeroPart>,
    /// Entries, part after part and block after block; in a block, for every column the first coordinates of its slots, then
    /// the second ones.
    pub values: Aligned,
}

/// A part of the state with the columns that are not zero on it.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct NonzeroPart {
    slots: Range<usize>,
    /// Indices of the columns.
    pub columns: Vec<usize>,
}

impl NonzeroPart {
    /// Its slots in blocks of [`BLOCK_SLOTS`] slots; the last block may have [`LANES`] slots.
    pub fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let end = self.slots.end;
        self.slots.clone().step_by(BLOCK_SLOTS).map(move |at| at..end.min(at + BLOCK_SLOTS))
    }
}

impl Columns {
    /// Packs columns over the parts of a state, which are ranges of slots.
    pub fn new(columns: &[Vec<f64>], parts: &[Range<usize>]) -> Self {
        let mut values = Vec::new();
        let mut touched = Vec::with_capacity(parts.len());
        for part in parts {
            let own: Vec<usize> = (0..columns.len()).filter(|k| is_nonzero_on(&columns[*k], part)).collect();
            let part = NonzeroPart { slots: part.clone(), columns: own };
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
}

/// Short columns in chunks of [`LANES`] entries. The chunks of all columns for the same entries are adjacent.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Number of columns.
    columns: usize,
    /// Chunks: first those of all columns for the first entries, and so on; the last are padded with zeros.
    pub values: Aligned,
}

impl Panel {
    /// Packs columns of `len` entries, which are given one after the other.
    pub fn new(columns: &[f64], len: usize) -> Self {
        let count = columns.len() / len.max(1);
        let mut values = vec![0.0; count * len.next_multiple_of(LANES)];
        for (k, column) in columns.chunks_exact(len.max(1)).enumerate() {
            for (chunk, entries) in column.chunks(LANES).enumerate() {
                let at = (chunk * count + k) * LANES;
                values[at..at + entries.len()].copy_from_slice(entries);
            }
        }
        Self { columns: count, values: aligned(&values) }
    }

    /// Reads an entry of a column.
    pub fn get(&self, column: usize, entry: usize) -> f64 {
        self.values[(entry / LANES * self.columns + column) * LANES + entry % LANES]
    }
}

/// Whether a vector of the length of the state has a nonzero entry in the slots `part`, in either half.
fn is_nonzero_on(vector: &[f64], part: &Range<usize>) -> bool {
    let (x, y) = vector.split_at(vector.len() / 2);
    [x, y].iter().any(|half| half[part.clone()].iter().any(|entry| *entry != 0.0))
}

/// Ranges of both coordinates of parts in a state with `slots` slots, in chunks; adjacent ranges are joined.
fn spans<'a>(slots: usize, parts: impl Iterator<Item = &'a Range<usize>> + Clone) -> Vec<Range<usize>> {
    let mut spans: Vec<Range<usize>> = Vec::new();
    let second = parts.clone().map(|part| part.start + slots..part.end + slots);
    for part in parts.cloned().chain(second) {
        let chunks = part.start / LANES..part.end / LANES;
        match spans.last_mut() {
            Some(last) if last.end == chunks.start => last.end = chunks.end,
            _ => spans.push(chunks),
        }
    }
    spans
}
