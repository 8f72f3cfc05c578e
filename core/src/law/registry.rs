//! One list of the laws makes [`LawSettings`](super::LawSettings), [`Law`](super::Law) and all that goes
//! through them.

/// Declares the laws, in the order of the stored record: a new one comes last. Each is a type that is a
/// [`ControlLaw`](super::ControlLaw) made from the gains in brackets.
macro_rules! laws {
    ($( $(#[doc = $doc:literal])+ $kind:literal $law:ident($gains:ty); )+) => {
        choice! {
            /// Which law, and its gains: what a gains file holds under `controller`, and beside it.
            pub enum LawSettings<R> {
                $( $(#[doc = $doc])+ $kind $law(gains: $gains) by $gains; )+
            }
        }

        /// Any law, at work. (The tag in a place of its own saves the tick from decoding it.)
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[repr(u8)]
        pub enum Law<R> {
            $( $(#[doc = $doc])+ $law($law<R>), )+
        }

        impl<R: Real> Law<R> {
            /// Ready to start; `sample_time` \[s\]. `effectiveness` \[N m/V\] serves laws that think in
            /// volts.
            pub fn new(settings: &LawSettings<R>, effectiveness: Effectiveness<R>, sample_time: R) -> Self {
                Self::start(*settings, effectiveness, sample_time)
            }
        }

        impl<R: Real> ControlLaw<R> for Law<R> {
            type Gains = LawSettings<R>;

            fn start(gains: LawSettings<R>, effectiveness: Effectiveness<R>, sample_time: R) -> Self {
                match gains {
                    $( LawSettings::$law(gains) => {
                        Self::$law($law::start(gains, effectiveness, sample_time))
                    } )+
                }
            }

            fn integrates(gains: &LawSettings<R>) -> R::Mask {
                match gains { $( LawSettings::$law(gains) => $law::integrates(gains), )+ }
            }

            #[inline(always)]
            fn torque(&mut self, now: &Situation<'_, R>) -> PerAxis<R> {
                match self { $( Self::$law(law) => law.torque(now), )+ }
            }

            #[inline(always)]
            fn restart(&mut self) {
                match self { $( Self::$law(law) => law.restart(), )+ }
            }

            #[inline(always)]
            fn settle(&mut self, now: &Situation<'_, R>, allocation: &Allocation<R>) {
                match self { $( Self::$law(law) => law.settle(now, allocation), )+ }
            }
        }
    };
}

pub(super) use laws;
