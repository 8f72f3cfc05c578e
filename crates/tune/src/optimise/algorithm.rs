//! The methods by name, behind one type.

use super::generations::AnyMethod;
use super::{
    AdaptiveFlowers, Best, Bounds, Candidate, CovarianceAdaptation, DifferentialEvolution, Draws,
    FlowerPollination, FpaSettings, Generations, Genetic, NelderMead, Optimiser, Rounds, Samples, Swarm,
    Variant, Wolves,
};
use serde::{Deserialize, Serialize};
use twinrotor_sim::{Error, Outcome};

/// A method of search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Algorithm {
    /// Flower pollination, one of three.
    Fpa(Variant),
    /// Flower pollination that adapts.
    FpaAdaptive,
    /// Genetic algorithm.
    Genetic,
    /// Particle swarm.
    Swarm,
    /// Grey wolves.
    Wolves,
    /// Differential evolution.
    Evolution,
    /// CMA-ES with restarts.
    Covariance,
    /// Nelder and Mead's simplex with restarts.
    NelderMead,
    /// Uniform random points.
    Random,
    /// Sobol's points.
    Sobol,
}

/// Every method by name.
pub const ALGORITHMS: [(&str, Algorithm); 12] = [
    ("fpa-paper", Algorithm::Fpa(Variant::Paper)),
    ("fpa-yang", Algorithm::Fpa(Variant::Yang)),
    ("fpa-demo", Algorithm::Fpa(Variant::Demo)),
    ("fpa-adaptive", Algorithm::FpaAdaptive),
    ("ga", Algorithm::Genetic),
    ("pso", Algorithm::Swarm),
    ("gwo", Algorithm::Wolves),
    ("de", Algorithm::Evolution),
    ("cmaes", Algorithm::Covariance),
    ("nelder-mead", Algorithm::NelderMead),
    ("random", Algorithm::Random),
    ("sobol", Algorithm::Sobol),
];

/// A method, and how much it may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setup {
    /// Which.
    pub algorithm: Algorithm,
    /// Candidates a generation; `None` for what the method is usually run with. Methods without a population
    /// ignore it.
    pub population: Option<usize>,
    /// Evaluations in all, at least 1.
    pub evaluations: usize,
}

/// Fewest candidates that every method can work with.
const LEAST: usize = 4;
/// Most evaluations of one search.
pub const MOST_EVALUATIONS: usize = 1_000_000_000;

impl Setup {
    /// Can it be run?
    ///
    /// # Errors
    ///
    /// If not: which number cannot be used, and what is allowed.
    pub fn validate(&self) -> Outcome<()> {
        if let Some(size) = self.population.filter(|n| !(LEAST..=100_000).contains(n)) {
            return Err(Error::invalid("population", size, format_args!("{LEAST} to 100000")));
        }
        if !(1..=MOST_EVALUATIONS).contains(&self.evaluations) {
            return Err(Error::invalid(
                "evaluations",
                self.evaluations,
                format_args!("1 to {MOST_EVALUATIONS}"),
            ));
        }
        Ok(())
    }

    /// A search at its beginning. `self` must be valid.
    pub fn start(&self, bounds: Bounds, draws: Draws) -> Searcher {
        let size = |usual: usize| self.population.unwrap_or(usual);
        let method = match self.algorithm {
            Algorithm::Fpa(variant) => {
                let published = FpaSettings::published(variant);
                let settings = FpaSettings {
                    population_size: size(published.population_size),
                    evaluations: self.evaluations,
                    ..published
                };
                return Searcher::Flowers(FlowerPollination::new(settings, bounds, draws));
            }
            Algorithm::FpaAdaptive => AnyMethod::Adaptive(AdaptiveFlowers::new(size(25))),
            Algorithm::Genetic => AnyMethod::Genetic(Genetic::new(size(50))),
            Algorithm::Swarm => AnyMethod::Swarm(Swarm::new(size(30))),
            Algorithm::Wolves => AnyMethod::Wolves(Wolves::new(size(30))),
            Algorithm::Evolution => AnyMethod::Evolution(DifferentialEvolution::new(size(30))),
            Algorithm::Covariance => AnyMethod::Covariance(CovarianceAdaptation::new(size(0))),
            Algorithm::NelderMead => AnyMethod::Simplex(NelderMead::new()),
            Algorithm::Random => AnyMethod::Samples(Samples::Random),
            Algorithm::Sobol => AnyMethod::Samples(Samples::Sobol),
        };
        Searcher::Generations(Generations::new(method, bounds, draws, self.evaluations))
    }
}

/// Any search in progress: what a checkpoint holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Searcher {
    /// A published form of flower pollination.
    Flowers(FlowerPollination),
    /// A method that moves whole generations.
    Generations(Generations),
    /// Any of them, over and over.
    Rounds(Box<Rounds>),
}

impl Searcher {
    fn inner(&self) -> &dyn Optimiser {
        match self {
            Self::Flowers(s) => s,
            Self::Generations(s) => s,
            Self::Rounds(s) => s.as_ref(),
        }
    }

    /// Could `begun`, which has only begun, have come to this? What a file holds need not be so.
    pub fn continues(&self, begun: &Self) -> bool {
        match (self, begun) {
            (Self::Flowers(then), Self::Flowers(begun)) => then.continues(begun),
            (Self::Generations(then), Self::Generations(begun)) => then.continues(begun),
            (Self::Rounds(then), Self::Rounds(begun)) => then.continues(begun),
            _ => false,
        }
    }

    /// The box that is searched; of rounds the last one's, nothing before the first.
    pub fn bounds(&self) -> Option<&Bounds> {
        match self {
            Self::Flowers(search) => Some(search.bounds()),
            Self::Generations(search) => Some(search.bounds()),
            Self::Rounds(search) => search.bounds(),
        }
    }

    /// One round more, of a search in rounds; others have none.
    pub fn add_round(&mut self) {
        if let Self::Rounds(search) = self {
            search.add();
        }
    }

    fn inner_mut(&mut self) -> &mut dyn Optimiser {
        match self {
            Self::Flowers(s) => s,
            Self::Generations(s) => s,
            Self::Rounds(s) => s.as_mut(),
        }
    }
}

impl Optimiser for Searcher {
    fn ask(&mut self) -> Vec<Candidate> {
        self.inner_mut().ask()
    }

    fn tell(&mut self, costs: &[f64]) {
        self.inner_mut().tell(costs);
    }

    fn best(&self) -> Option<&Best> {
        self.inner().best()
    }

    fn evaluations(&self) -> usize {
        self.inner().evaluations()
    }

    fn budget(&self) -> usize {
        self.inner().budget()
    }
}
