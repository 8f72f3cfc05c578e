//! `twinrotor._native`: the engine as Python calls it. Text and numbers come in, arrays and JSON go out; what
//! is pleasant to use of it is written in Python, in `python/twinrotor`.

mod batch;
mod board;
mod comparison;
mod contest;
mod coverage;
mod flight;
mod identification;
mod linear;
mod logs;
mod margins;
mod parts;
mod replay;
mod search;
mod settings;
mod waiting;

/// The engine.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::batch::Batch;
    #[pymodule_export]
    use crate::board::{Bench, ControlLoop, SimulatedBoard};
    #[pymodule_export]
    use crate::comparison::{compare, compare_chunk, compare_chunks, draw};
    #[pymodule_export]
    use crate::contest::{bench_tuner, holm, rank_sum, standings};
    #[pymodule_export]
    use crate::coverage::{coverage_chunk, coverage_chunks};
    #[pymodule_export]
    use crate::flight::simulate;
    #[pymodule_export]
    use crate::identification::identify;
    #[pymodule_export]
    use crate::linear::linearize;
    #[pymodule_export]
    use crate::margins::margins;
    #[pymodule_export]
    use crate::parts::{gains_file, preset_names, rig_file};
    #[pymodule_export]
    use crate::replay::replay;
    #[pymodule_export]
    use crate::search::{robust_costs, tune, tune_robust};
    #[pymodule_export]
    use crate::settings::settings;
}
