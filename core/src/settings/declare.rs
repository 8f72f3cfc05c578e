//! The macros that declare settings. Plain `macro_rules!`, so that the core needs no other program to build.

/// Declares a structure of numbers with its table, `map` and `validate`.
///
/// ```text
/// settings! {
///     /// The gains of one axis.
///     pub struct PidGains<R> at "pitch.", "yaw." {
///         /// k_p.
///         proportional: (R) "1/s²", (at least 0), typical 0.0 to 300.0, default 64.0;
///     }
/// }
/// ```
///
/// `at` is where the structure stands in a controller, once for each place. A type is `R`, `bool`,
/// `PerAxis<R>`, `Option<PerAxis<R>>` or `MotorGains<R>`. `and` names a rule on several fields at once.
macro_rules! settings {
    (
        $(#[$meta:meta])*
        pub struct $name:ident<R> at $($place:literal),+ $(; and $rule:path)? {
            $( $(#[doc = $doc:literal])+ $field:ident: ($($type:tt)+) $unit:literal, $range:tt,
               typical $low:literal to $high:literal, default $default:expr; )+
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name<R> {
            $(
                #[doc = concat!("\\[", $unit, "\\]", $($doc),+)]
                #[doc = concat!("Allowed: ", settings_range!(@text $range), ".")]
                pub $field: $($type)+,
            )+
        }

        table! {
            [<R>] [$name<R>] at ($($place),+) {
                $( $(#[doc = $doc])+ $field: ($($type)+) $unit, $range,
                   typical $low to $high, default $default; )+
            }
        }

        impl<R: $crate::real::Real> $crate::settings::Leaves<R> for $name<R> {
            type Of<U> = $name<U>;

            fn map_each<U, F: FnMut(R) -> U>(self, f: &mut F) -> $name<U> {
                $name {
                    $( $field: <$($type)+ as $crate::settings::Leaves<R>>::map_each(self.$field, f), )+
                }
            }

            fn change<F: FnMut(usize, R) -> R>(&mut self, first: usize, f: &mut F) -> usize {
                use $crate::settings::Leaves;
                $( let first = <$($type)+ as Leaves<R>>::change(&mut self.$field, first, f); )+
                first
            }
        }

        impl<R: $crate::real::Real> $crate::settings::Build<R> for $name<R> {
            fn build<F: FnMut(usize) -> R>(first: usize, f: &mut F) -> (Self, usize) {
                $( let ($field, first) = <$($type)+ as $crate::settings::Build<R>>::build(first, f); )+
                (Self { $($field),+ }, first)
            }
        }

        impl<R: $crate::real::Real> $name<R> {
            /// Each number through `f`.
            pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> $name<U> {
                $crate::settings::Leaves::map_each(self, &mut f)
            }
        }

        impl<R: $crate::real::Real<Mask = bool>> $name<R> {
            /// Every number allowed; named as in the first of the places where such a structure stands.
            ///
            /// # Errors
            /// Names the field.
            pub fn validate(&self) -> Result<(), $crate::validate::Invalid<R>> {
                $crate::settings::check(self, <Self as $crate::settings::Table>::RULES)?;
                $( $rule(self)?; )?
                Ok(())
            }
        }
    };
}

/// Declares the table of a type: what [`settings!`] does without the structure. `[<R>]` are the type's
/// parameters. Goes through the places, and for each through the fields, and makes a row of every leaf.
macro_rules! table {
    ([$($generics:tt)*] [$($name:tt)+] at ($($place:literal),+) $fields:tt) => {
        settings_rows! { @place ([$($generics)*] [$($name)+] $fields) [] ($($place,)+) }
    };
}

macro_rules! settings_rows {
    (@place ($generics:tt $name:tt {$($field:tt)+}) $done:tt ($place:literal, $($later:tt)*)) => {
        settings_rows! {
            @field ($generics $name {$($field)+}) $done ($($later)*) $place $($field)+
        }
    };
    (@place ([$($generics:tt)*] [$($name:tt)+] $fields:tt) [$($row:tt)*] ()) => {
        impl $($generics)* $crate::settings::Table for $($name)+ {
            const FIELDS: &'static [$crate::settings::Field] =
                &[$( settings_row!(@field $row) ),*];
            const RULES: &'static [$crate::settings::Rule] =
                &[$( settings_row!(@rule $row) ),*];
        }
    };
    (@field $for:tt $done:tt $later:tt $place:literal) => {
        settings_rows! { @place $for $done $later }
    };
    (@field $for:tt $done:tt $later:tt $place:literal
        $(#[doc = $doc:literal])+ $field:ident: $type:tt $unit:literal, $range:tt,
        typical $low:literal to $high:literal, default $default:expr; $($rest:tt)*
    ) => {
        settings_rows! {
            @leaves $type $for $done $later $place $field
            ($unit, $range, [$low, $high], $default, concat!($($doc),+)) $($rest)*
        }
    };
    // The leaves of each type that a field may have.
    (@leaves (R) $($state:tt)+) => { settings_rows! { @push [""] $($state)+ } };
    (@leaves (bool) $($state:tt)+) => { settings_rows! { @push [""] $($state)+ } };
    (@leaves (PerAxis<R>) $($state:tt)+) => {
        settings_rows! { @push [".pitch" ".yaw"] $($state)+ }
    };
    (@leaves (Option<PerAxis<R>>) $($state:tt)+) => {
        settings_rows! { @push [".pitch" ".yaw"] $($state)+ }
    };
    (@leaves (MotorGains<R>) $($state:tt)+) => {
        settings_rows! {
            @push [".main.pitch" ".main.yaw" ".tail.pitch" ".tail.yaw"] $($state)+
        }
    };
    (@push [$($leaf:literal)+] $for:tt [$($done:tt)*] $later:tt $place:literal $field:ident $about:tt
        $($rest:tt)*
    ) => {
        settings_rows! {
            @field $for [$($done)* $( {concat!($place, stringify!($field), $leaf), $about} )+]
            $later $place $($rest)*
        }
    };
}

macro_rules! settings_row {
    (@field {$name:expr, ($unit:literal, $range:tt, $typical:expr, $default:expr, $doc:expr)}) => {
        $crate::settings::Field {
            name: $name,
            unit: $unit,
            range: settings_range!($range),
            typical: $typical,
            default: $default,
            doc: $doc.trim_ascii(),
        }
    };
    (@rule {$name:expr, ($unit:literal, $range:tt, $typical:expr, $default:expr, $doc:expr)}) => {
        $crate::settings::Rule { name: $name, range: settings_range!($range) }
    };
}

macro_rules! settings_range {
    ((finite)) => {
        $crate::settings::Range::Finite
    };
    ((at least 0)) => {
        $crate::settings::Range::AtLeastZero
    };
    ((above 0)) => {
        $crate::settings::Range::AboveZero
    };
    ((switch)) => {
        $crate::settings::Range::Switch
    };
    (($least:literal to $most:literal)) => {
        $crate::settings::Range::Between(
            &const {
                $crate::settings::Interval::new($least as f64, $most as f64, concat!($least, " to ", $most))
            },
        )
    };
    (@text (finite)) => {
        "any"
    };
    (@text (at least 0)) => {
        "at least 0"
    };
    (@text (above 0)) => {
        "above 0"
    };
    (@text (switch)) => {
        "yes or no"
    };
    (@text ($least:literal to $most:literal)) => {
        concat!($least, " to ", $most)
    };
}

/// Declares a choice: an enum of kinds with the name that files use, each with the table of its numbers.
///
/// ```text
/// choice! {
///     /// What becomes of a demand that the motors cannot meet.
///     pub enum AllocationSettings<R> {
///         /// Each motor's volts limited on their own.
///         "clamp" Clamp by ();
///         /// The volts that come nearest to the accelerations asked for.
///         "weighted" Weighted { pitch_weight: R } by Weight;
///     }
/// }
/// ```
macro_rules! choice {
    (
        $(#[$meta:meta])*
        pub enum $name:ident<R> {
            $( $(#[doc = $doc:literal])+ $kind:literal $variant:ident
               $( ($gains:ident: $type:ty) )? $( { $($field:ident: $of:ty),+ } )? by $table:ty; )+
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub enum $name<R> {
            $(
                $(#[doc = $doc])+
                #[serde(rename = $kind)]
                $variant $( ($type) )? $( {
                    $(
                        #[doc = concat!("See the table of [`", stringify!($name), "::KINDS`].")]
                        $field: $of,
                    )+
                } )?,
            )+
        }

        impl<R> $name<R> {
            /// What there is to choose from, in the order of the stored record.
            pub const KINDS: &'static [$crate::settings::Kind] = &[$(
                $crate::settings::Kind {
                    name: $kind,
                    doc: concat!($($doc),+).trim_ascii(),
                    fields: <$table as $crate::settings::Table>::FIELDS,
                },
            )+];

            /// Which of [`Self::KINDS`] it is, by name.
            pub const fn kind(&self) -> &'static str {
                match self { $( Self::$variant { .. } => $kind, )+ }
            }

            /// Its numbers' fields.
            pub const fn fields(&self) -> &'static [$crate::settings::Field] {
                match self { $( Self::$variant { .. } => <$table as $crate::settings::Table>::FIELDS, )+ }
            }

            const fn rules(&self) -> &'static [$crate::settings::Rule] {
                match self { $( Self::$variant { .. } => <$table as $crate::settings::Table>::RULES, )+ }
            }
        }

        impl<R: $crate::real::Real> $crate::settings::Leaves<R> for $name<R> {
            type Of<U> = $name<U>;

            fn map_each<U, F: FnMut(R) -> U>(self, _f: &mut F) -> $name<U> {
                use $crate::settings::Leaves;
                match self { $(
                    Self::$variant $( ($gains) )? $( { $($field),+ } )? => $name::$variant
                        $( (<$type as Leaves<R>>::map_each($gains, _f)) )?
                        $( { $( $field: <$of as Leaves<R>>::map_each($field, _f) ),+ } )?,
                )+ }
            }

            fn change<F: FnMut(usize, R) -> R>(&mut self, first: usize, _f: &mut F) -> usize {
                use $crate::settings::Leaves;
                match self { $(
                    Self::$variant $( ($gains) )? $( { $($field),+ } )? => {
                        $( let first = <$type as Leaves<R>>::change($gains, first, _f); )?
                        $( $( let first = <$of as Leaves<R>>::change($field, first, _f); )+ )?
                        first
                    }
                )+ }
            }
        }

        impl<R: $crate::real::Real> $name<R> {
            /// The kind of this name, its numbers as the table's defaults have them.
            pub fn named(kind: &str) -> Option<Self> {
                $( if kind == $kind {
                    let _fields = <$table as $crate::settings::Table>::FIELDS;
                    return Some(Self::$variant
                        $( ($crate::settings::defaults::<R, $type>(_fields)) )?
                        $( { $( $field: $crate::settings::defaults::<R, $of>(_fields) ),+ } )?);
                } )+
                None
            }

            /// Each number through `f`.
            pub fn map<U>(self, mut f: impl FnMut(R) -> U) -> $name<U> {
                $crate::settings::Leaves::map_each(self, &mut f)
            }
        }

        impl<R: $crate::real::Real<Mask = bool>> $name<R> {
            /// Every number allowed.
            ///
            /// # Errors
            /// Names the field.
            pub fn validate(&self) -> Result<(), $crate::validate::Invalid<R>> {
                $crate::settings::check(self, self.rules())
            }
        }
    };
}
