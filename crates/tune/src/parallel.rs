//! The same work on every item of a list: on all processors with the feature `threads`, else in turn. What
//! comes out is in the order of the list, and the same bytes either way.

#[cfg(feature = "threads")]
use rayon::prelude::*;

/// `of` every item.
#[cfg(feature = "threads")]
pub fn map<T: Sync, U: Send>(items: &[T], of: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
    items.par_iter().map(of).collect()
}

/// `of` every item.
#[cfg(not(feature = "threads"))]
pub fn map<T, U>(items: &[T], of: impl Fn(&T) -> U) -> Vec<U> {
    items.iter().map(of).collect()
}

/// `of` every group of up to `size` neighbours, one after the other in one list.
#[cfg(feature = "threads")]
pub fn by_group<T: Sync, U: Send>(
    items: &[T],
    size: usize,
    of: impl Fn(&[T]) -> Vec<U> + Sync + Send,
) -> Vec<U> {
    items.par_chunks(size).flat_map_iter(of).collect()
}

/// `of` every group of up to `size` neighbours, one after the other in one list.
#[cfg(not(feature = "threads"))]
pub fn by_group<T, U>(items: &[T], size: usize, of: impl Fn(&[T]) -> Vec<U>) -> Vec<U> {
    items.chunks(size).flat_map(of).collect()
}

/// `of` every number below `count`.
#[cfg(feature = "threads")]
pub fn by_index<U: Send>(count: usize, of: impl Fn(usize) -> U + Sync + Send) -> Vec<U> {
    (0..count).into_par_iter().map(of).collect()
}

/// `of` every number below `count`.
#[cfg(not(feature = "threads"))]
pub fn by_index<U>(count: usize, of: impl Fn(usize) -> U) -> Vec<U> {
    (0..count).map(of).collect()
}
