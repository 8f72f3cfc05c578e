//! Twinrotor's tuner: methods of search, what they minimise, which of a controller's numbers they may move,
//! and the designs that they start from. No files, no terminal; threads by the feature `threads`, without
//! which the same bytes come out one after the other.
//!
//! The paper's problem with the paper's method, in ten lines:
//!
//! ```
//! use twinrotor::{gains, plant::presets::PAPER};
//! use twinrotor_sim::{Error, flight::Fidelity, gains_file::GainsFile};
//! use twinrotor_sim::{metrics::Criterion, scenario::Scenario};
//! use twinrotor_tune::checkpoint::Identity;
//! use twinrotor_tune::integral::Objective;
//! use twinrotor_tune::optimise::{Algorithm, Bounds, Draws, Setup, Variant};
//! use twinrotor_tune::search::Search;
//!
//! let problem = Objective::new(Criterion::Ise, &PAPER, &Scenario::named("step")?, Fidelity::Ideal, 1);
//! let setup = Setup { algorithm: Algorithm::Fpa(Variant::Paper), population: None, evaluations: 200 };
//! let bounds = Bounds::new(vec![gains::PAPER_BOUNDS; 4])?;
//! let mut search = Search::new(Identity::new(), setup.start(bounds, Draws::new(1)));
//! search.to_the_end(&problem);
//! let best = search.best().expect("one of 200 flies");
//! assert!(best.cost < 0.55 * problem.cost(&GainsFile::paper()), "Table 4 is far from the optimum");
//! println!("{}", Objective::controller(&best.position).to_toml());
//! # Ok::<(), Error>(())
//! ```

#![cfg_attr(
    test,
    allow(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "tests compare bits and make samples"
    )
)]

pub mod checkpoint;
pub mod contest;
pub mod design;
pub mod integral;
pub mod landscape;
pub mod optimise;
pub mod parallel;
pub mod robust;
pub mod search;
pub mod tunable;
