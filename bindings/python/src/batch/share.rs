//! Neighbouring environments, in groups of as many as there are lanes.

use super::task::{Autoreset, Episode, SEEN, Task};
use super::world::{World, world};
use twinrotor::axes::PerAxis;
use twinrotor_sim::lanes::LANES;

/// What is to be done with all.
#[derive(Debug, Clone, Copy)]
pub(super) enum Job {
    /// Those that are asked to begin anew.
    Reset,
    /// An action each.
    Step,
}

/// Is an environment to begin anew?
#[derive(Debug, Clone, Copy)]
pub(super) enum Wish {
    Stay,
    /// With the next of its episodes.
    Next,
    /// With the first episode of a seed.
    Seed(u64),
}

/// What came of it: a row or a number for each environment.
#[derive(Debug)]
pub(super) struct Results {
    pub(super) observations: Vec<[f32; SEEN]>,
    /// What was last seen of an episode after which another one has begun in the same step.
    pub(super) finals: Vec<[f32; SEEN]>,
    pub(super) rewards: Vec<f64>,
    pub(super) terminated: Vec<bool>,
    pub(super) truncated: Vec<bool>,
}

/// What goes in and comes out, and the groups.
pub(super) struct Share {
    task: Task,
    groups: Vec<Group>,
    pub(super) actions: Vec<[f32; 2]>,
    pub(super) wishes: Vec<Wish>,
    pub(super) results: Results,
}

struct Group {
    world: Box<dyn World>,
    episodes: Vec<Episode>,
}

impl Share {
    pub(super) fn new(task: &Task, count: usize) -> Self {
        let group = |first: usize| Group {
            world: world(task),
            episodes: vec![Episode::default(); LANES.min(count - first)],
        };
        Self {
            task: *task,
            groups: (0..count).step_by(LANES).map(group).collect(),
            actions: vec![[0.0; 2]; count],
            wishes: vec![Wish::Stay; count],
            results: Results {
                observations: vec![[0.0; SEEN]; count],
                finals: vec![[0.0; SEEN]; count],
                rewards: vec![0.0; count],
                terminated: vec![false; count],
                truncated: vec![false; count],
            },
        }
    }

    pub(super) fn count(&self) -> usize {
        self.actions.len()
    }

    /// The episodes, in the order of the environments.
    pub(super) fn episodes(&self) -> impl Iterator<Item = &Episode> {
        self.groups.iter().flat_map(|group| &group.episodes)
    }

    pub(super) fn work(&mut self, job: Job) {
        for k in 0..self.groups.len() {
            match job {
                Job::Reset => self.reset(k),
                Job::Step => self.step(k),
            }
        }
    }

    fn reset(&mut self, group: usize) {
        let first = group * LANES;
        let Group { world, episodes } = &mut self.groups[group];
        let mut drawn = [None; LANES];
        for (lane, episode) in episodes.iter_mut().enumerate() {
            let at = first + lane;
            match std::mem::replace(&mut self.wishes[at], Wish::Stay) {
                Wish::Stay => continue,
                Wish::Next => {}
                Wish::Seed(seed) => episode.seed(seed),
            }
            let (draw, seen) = episode.begin(&self.task);
            drawn[lane] = Some(draw);
            self.results.observations[at] = seen;
        }
        if drawn.iter().any(Option::is_some) {
            world.begin(&drawn);
        }
    }

    fn step(&mut self, group: usize) {
        let first = group * LANES;
        let Group { world, episodes } = &mut self.groups[group];
        let mut asked = [[0.0; 2]; LANES];
        let mut goals = [PerAxis::zero(); LANES];
        for (lane, episode) in episodes.iter().enumerate() {
            asked[lane] = self.task.asked(self.actions[first + lane]);
            goals[lane] = episode.goal;
        }
        let seen = world.advance(&asked, &goals);
        let mut drawn = [None; LANES];
        let results = &mut self.results;
        for (lane, episode) in episodes.iter_mut().enumerate() {
            let at = first + lane;
            // An action at an episode's end does nothing but begin the next one.
            if episode.over {
                let (draw, seen) = episode.begin(&self.task);
                drawn[lane] = Some(draw);
                results.observations[at] = seen;
                results.rewards[at] = 0.0;
                (results.terminated[at], results.truncated[at]) = (false, false);
                continue;
            }
            let outcome = episode.flown(&seen[lane]);
            results.observations[at] = episode.shows(&seen[lane]);
            results.rewards[at] = outcome.reward;
            (results.terminated[at], results.truncated[at]) = (outcome.terminated, outcome.truncated);
            if episode.over && self.task.autoreset == Autoreset::SameStep {
                results.finals[at] = results.observations[at];
                let (draw, seen) = episode.begin(&self.task);
                drawn[lane] = Some(draw);
                results.observations[at] = seen;
            }
        }
        if drawn.iter().any(Option::is_some) {
            world.begin(&drawn);
        }
    }
}
