use super::*;
use std::vec::Vec;

const STATES: [ArmState; 5] = [
    ArmState::Disarmed,
    ArmState::Ready,
    ArmState::Checking,
    ArmState::Armed,
    ArmState::Fault(Condition::NonFinite),
];
const REQUESTS: [Option<Request>; 5] =
    [None, Some(Request::Arm), Some(Request::Disarm), Some(Request::ClearFault), Some(Request::Check)];

/// Every state with every request under no condition, and under each single one: 5 x 5 x 25 cases.
fn every_case() -> impl Iterator<Item = (ArmState, Option<Request>, Conditions, ArmState)> {
    let sets: Vec<Conditions> = core::iter::once(Conditions::NONE)
        .chain(Condition::ALL.map(|condition| Conditions::of(&[condition])))
        .collect();
    STATES.into_iter().flat_map(move |state| {
        let sets = sets.clone();
        REQUESTS.into_iter().flat_map(move |request| {
            let sets = sets.clone();
            sets.into_iter().map(move |present| {
                let mut supervisor = Supervisor { state, ..Supervisor::default() };
                let changes = supervisor.step(present, request);
                assert_eq!(changes, supervisor.state() != state);
                (state, request, present, supervisor.state())
            })
        })
    })
}

#[test]
fn each_condition_has_its_own_bit_and_comes_back_by_it() {
    for (bit, condition) in Condition::ALL.into_iter().enumerate() {
        assert_eq!(condition as usize, bit);
        assert_eq!(Conditions::of(&[condition]).iter().collect::<Vec<_>>(), [condition]);
    }
}

#[test]
fn only_arm_in_ready_with_nothing_wrong_leads_to_armed() {
    for (from, request, present, to) in every_case() {
        if to == ArmState::Armed && from != ArmState::Armed {
            assert_eq!((from, request, present), (ArmState::Ready, Some(Request::Arm), Conditions::NONE));
        }
    }
}

#[test]
fn a_hazard_stops_turning_motors_in_the_same_tick_and_is_named() {
    for (from, _, present, to) in every_case() {
        let hazard = present.intersection(Conditions::HAZARDS).first();
        if let (true, Some(cause)) = (from.motors_may_turn(), hazard) {
            assert_eq!(to, ArmState::Fault(cause));
        }
        if hazard.is_some() {
            assert!(!to.motors_may_turn());
        }
    }
}

#[test]
fn a_fault_stays_until_it_is_cleared_with_no_hazard_left() {
    for (from, request, present, to) in every_case() {
        let safe = present.intersection(Conditions::HAZARDS).is_empty();
        if let ArmState::Fault(_) = from {
            let cleared = request == Some(Request::ClearFault) && safe;
            assert_eq!(to, if cleared { ArmState::Disarmed } else { from });
        }
    }
}

#[test]
fn disarm_always_ends_turning_motors() {
    for (_, request, _, to) in every_case() {
        assert!(request != Some(Request::Disarm) || !to.motors_may_turn());
    }
}

#[test]
fn ready_means_that_nothing_prevents_arming() {
    for (from, request, present, to) in every_case() {
        if to == ArmState::Ready {
            assert_eq!(present, Conditions::NONE);
            assert!(from == ArmState::Ready || (from == ArmState::Disarmed && request.is_none()));
        }
    }
}

#[test]
fn the_check_starts_without_zero_but_not_with_a_hazard_nor_on_a_board_that_is_not_as_it_should_be() {
    let board = Conditions::of(&[
        Condition::ParametersMissing,
        Condition::ParametersInvalid,
        Condition::ClockFallback,
        Condition::DebugBuild,
    ]);
    for (from, request, present, to) in every_case() {
        if request == Some(Request::Check) && matches!(from, ArmState::Disarmed | ArmState::Ready) {
            let prevents = Conditions::HAZARDS.union(board);
            assert_eq!(to == ArmState::Checking, present.intersection(prevents).is_empty());
        }
    }
}

#[test]
fn a_reset_that_should_not_have_been_is_a_fault_from_the_start() {
    let mut supervisor = Supervisor::new(Some(Condition::ResetByWatchdog));
    assert!(!supervisor.step(Conditions::NONE, Some(Request::Arm)));
    assert_eq!(supervisor.state(), ArmState::Fault(Condition::ResetByWatchdog));
    assert!(supervisor.step(Conditions::NONE, Some(Request::ClearFault)));
    assert_eq!(supervisor.state(), ArmState::Disarmed);
    assert_eq!(Supervisor::new(None).state(), ArmState::Disarmed);
}

/// Over random ticks: armed only ever from ready, and never in a tick with a hazard; and that no step is made
/// where nothing is new makes no difference.
#[test]
fn long_random_runs_keep_the_rules() {
    let mut seed = 1_u32;
    let mut supervisor = Supervisor::new(None);
    let (mut armed, mut left_out) = (0, 0);
    for _ in 0..200_000 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let present = match seed >> 28 {
            0 => Conditions(1 << ((seed >> 20) % Condition::ALL.len() as u32)),
            _ => Conditions::NONE,
        };
        let before = supervisor.state();
        let request = REQUESTS[(seed >> 16) as usize % 8 % 5];
        let (unmoved, settled) = (supervisor, request.is_none() && supervisor.is_settled(present));
        supervisor.step(present, request);
        let after = supervisor.state();
        if settled {
            assert_eq!(supervisor, unmoved);
            left_out += 1;
        }
        assert_eq!(supervisor.has_changed(), (after, present) != (before, unmoved.present()));
        if after == ArmState::Armed {
            armed += 1;
            assert!(matches!(before, ArmState::Ready | ArmState::Armed));
            assert!(present.intersection(Conditions::HAZARDS).is_empty());
        }
    }
    assert!(armed > 1_000, "the walk reaches every state: {armed}");
    assert!(left_out > 1_000, "and has steps that need not be made: {left_out}");
}
