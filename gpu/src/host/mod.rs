//! The other side: what puts flights on a card and takes their sums from it.

mod card;
#[cfg(feature = "cuda")]
pub mod cuda;
pub mod driver;
pub mod stand_in;
mod work;
mod write;

pub use card::Card;
pub use write::written;
