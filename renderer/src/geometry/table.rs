//! Large read-only arrays on large pages.
//!
//! A traversal touches nodes and triangles in random order: with pages of 4 kB most of its time goes into
//! finding the pages. Tables of several megabytes lie in memory that the system is asked to back by large
//! pages; where it does not, they are as any other memory.

use bytemuck::Pod;
use memmap2::MmapMut;
use std::ops::Deref;

/// Smaller tables stay where they are.
const LARGE: usize = 4 << 20;

/// An array that no longer changes.
#[derive(Debug)]
pub enum Table<T> {
    /// On the heap.
    Heap(Vec<T>),
    /// In pages of its own; the length in elements.
    Pages(MmapMut, usize),
}

impl<T: Pod> Table<T> {
    /// Moves `elements` to large pages if they are large.
    pub fn new(elements: Vec<T>) -> Self {
        let bytes: &[u8] = bytemuck::cast_slice(&elements);
        if bytes.len() < LARGE {
            return Self::Heap(elements);
        }
        // Without memory for a second copy the first one serves as well.
        let Ok(mut pages) = MmapMut::map_anon(bytes.len()) else { return Self::Heap(elements) };
        #[cfg(target_os = "linux")]
        let _ = pages.advise(memmap2::Advice::HugePage);
        pages[..bytes.len()].copy_from_slice(bytes);
        Self::Pages(pages, elements.len())
    }
}

impl<T: Pod> Deref for Table<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            Self::Heap(elements) => elements,
            Self::Pages(pages, len) => bytemuck::cast_slice(&pages[..len * size_of::<T>()]),
        }
    }
}

impl<T> Default for Table<T> {
    fn default() -> Self {
        Self::Heap(Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_table_has_the_elements() {
        let elements: Vec<u32> = (0..3_000_000).collect();
        let table = Table::new(elements.clone());
        assert!(matches!(table, Table::Pages(..)));
        assert_eq!(&table[..], &elements[..]);
        assert!(Table::<u32>::default().is_empty());
    }
}
