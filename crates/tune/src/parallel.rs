//! The same work on every item of a list: on all processors with the feature `threads`, else in turn. What
//! comes out is in the order of the list, and the same bytes either way.

#[cfg(feature = "threads")]
use rayon::prelude::*;

/// Asked between one piece of work and the next: is the result of no more use? Then nothing is given.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// The result is wanted whatever happens.
pub const NEVER: Stop<'static> = &|| false;

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

/// `of` every item, or nothing if one has nothing.
#[cfg(feature = "threads")]
pub fn try_map<T: Sync, U: Send>(items: &[T], of: impl Fn(&T) -> Option<U> + Sync + Send) -> Option<Vec<U>> {
    items.par_iter().map(of).collect()
}

/// `of` every item, or nothing if one has nothing.
#[cfg(not(feature = "threads"))]
pub fn try_map<T, U>(items: &[T], of: impl Fn(&T) -> Option<U>) -> Option<Vec<U>> {
    items.iter().map(of).collect()
}

/// `of` every group of up to `size` neighbours, one after the other in one list, or nothing if one has
/// nothing.
pub fn by_group<T: Sync, U: Send>(
    items: &[T],
    size: usize,
    of: impl Fn(&[T]) -> Option<Vec<U>> + Sync + Send,
) -> Option<Vec<U>> {
    let groups: Vec<&[T]> = items.chunks(size).collect();
    Some(try_map(&groups, |group| of(group))?.into_iter().flatten().collect())
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
