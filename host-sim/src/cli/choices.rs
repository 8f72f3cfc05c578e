//! What can be chosen by name on the command line, and what it means to the crates that compute.

use clap::ValueEnum;
use twinrotor_sim::flight;
use twinrotor_tune::robust;

/// Declares choices that mirror those of a library, in its order.
macro_rules! mirror {
    ($(#[$meta:meta])* $name:ident of $theirs:path { $($(#[$doc:meta])* $variant:ident),* $(,)? }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
        pub(super) enum $name { $($(#[$doc])* $variant),* }

        impl From<$name> for $theirs {
            fn from(choice: $name) -> Self {
                match choice { $($name::$variant => Self::$variant),* }
            }
        }
    };
}

mirror! {
    /// Which world.
    Fidelity of flight::Fidelity {
        /// The paper's: true state, no lag, no quantisation, no delay, 1 kHz hold
        Ideal,
        /// The rig's: encoder counts, estimated rates, rotor lag, one tick of delay, PWM steps
        Rig,
    }
}

mirror! {
    /// Which arithmetic.
    Scalar of flight::Scalar {
        /// As the board computes
        F32,
        /// To verify
        F64,
    }
}

mirror! {
    /// What is flown on every plant.
    Scenes of robust::Scenes {
        /// The cold step from rest alone
        Step,
        /// Beside it the step the other way, a far step, a gust while moving, a sine, hot reversals
        All,
    }
}
