//! The values of a slice, each estimated several times.
//!
//! A repeat is the whole slice by one set of random numbers. Repeats are independent of each other;
//! within one the points may well have the same random numbers, and so noise in common. Intervals of
//! 95 % are Student's t of the jackknife (J. Tukey, *Bias and confidence in not quite large samples*,
//! Annals of Mathematical Statistics 29, 1958), which leaves out one repeat at a time:
//!
//! ```text
//! error^2 = (R - 1) / R sum_r (s_(-r) - mean s_(-))^2
//! ```

use statrs::distribution::{ContinuousCDF, StudentsT};
use streams::Normals;

use crate::{
    Error,
    inner::{dot, sum},
};

/// A slice's values: `[n_repeats x n_points]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Repeats(Vec<Vec<f64>>);

/// A number with its interval of 95 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// The lower end of its interval.
    pub low: f64,
    /// The upper end of its interval.
    pub high: f64,
}

impl Repeats {
    /// Takes `[n_repeats x n_points]`.
    ///
    /// # Errors
    /// Fewer than two repeats or three points; repeats of different lengths; what isn't finite.
    pub fn new(values: Vec<Vec<f64>>) -> Result<Self, Error> {
        let refuse = |expected, got: usize| Err(Error::new("repeats of a slice", expected, got));
        let n_points = values.first().map_or(0, Vec::len);
        if values.len() < 2 {
            return refuse("at least 2 of them", values.len());
        }
        if n_points < 3 {
            return refuse("at least 3 points", n_points);
        }
        if let Some(other) = values.iter().find(|it| it.len() != n_points) {
            return refuse("as many points in each", other.len());
        }
        require_finite(&values)?;
        Ok(Self(values))
    }

    /// The number of repeats, at least 2.
    #[must_use]
    pub fn n(&self) -> usize {
        self.0.len()
    }

    /// The number of points, at least 3.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.0[0].len()
    }

    /// `[n_repeats x n_points]`
    #[must_use]
    pub fn values(&self) -> &[Vec<f64>] {
        &self.0
    }

    /// The mean over repeats, `[n_points]`.
    #[must_use]
    pub fn mean(&self) -> Vec<f64> {
        mean(&self.0)
    }

    /// The standard error of each mean, `[n_points]`.
    #[must_use]
    pub fn errors(&self) -> Vec<f64> {
        let (n, mean) = (self.n() as f64, self.mean());
        let square = |i: usize| {
            let squares = self.0.iter().map(|repeat| (repeat[i] - mean[i]) * (repeat[i] - mean[i]));
            squares.sum::<f64>() / (n * (n - 1.0))
        };
        (0..self.n_points()).map(|i| square(i).sqrt()).collect()
    }

    /// Each repeat less its own mean over the points, `[n_repeats x n_points]`.
    #[must_use]
    pub fn centred(&self) -> Vec<Vec<f64>> {
        let n = self.n_points() as f64;
        let centred = |repeat: &Vec<f64>| {
            let mean = repeat.iter().sum::<f64>() / n;
            repeat.iter().map(|value| value - mean).collect()
        };
        self.0.iter().map(centred).collect()
    }

    /// What the mean would look like if there were nothing but noise: normal, with the covariance that
    /// the mean of these repeats has,
    ///
    /// ```text
    /// e = sum_r g_r (x_r - m) / sqrt(R (R - 1)),   g_r of N(0,1)
    /// ```
    ///
    /// which is the multiplier bootstrap of V. Chernozhukov, D. Chetverikov and K. Kato, *Gaussian
    /// approximations and multiplier bootstrap for maxima of sums of high-dimensional random vectors*,
    /// Annals of Statistics 41 (2013). Any noise will do: correlated, and other at every point.
    pub(crate) fn noise(&self, normals: &mut Normals) -> Vec<f64> {
        let (n, mean) = (self.n() as f64, self.mean());
        let scale = 1.0 / (n * (n - 1.0)).sqrt();
        let mut noise = vec![0.0; self.n_points()];
        for repeat in &self.0 {
            let g = scale * normals.draw();
            for ((noise, value), mean) in noise.iter_mut().zip(repeat).zip(&mean) {
                *noise += g * (value - mean);
            }
        }
        noise
    }
}

impl Estimate {
    /// A statistic of some repeats, by the jackknife. None if the statistic has none of all or of all
    /// but one.
    pub(crate) fn jackknife(
        n_repeats: usize,
        statistic: impl Fn(&[usize]) -> Option<f64>,
    ) -> Option<Self> {
        let all: Vec<usize> = (0..n_repeats).collect();
        let value = statistic(&all)?;
        if n_repeats < 3 {
            // All but one are one, which knows nothing of its noise.
            return Some(Self { value, low: f64::NEG_INFINITY, high: f64::INFINITY });
        }
        let without = |left_out: usize| {
            let others: Vec<usize> = all.iter().copied().filter(|&r| r != left_out).collect();
            statistic(&others)
        };
        let parts = (0..n_repeats).map(without).collect::<Option<Vec<f64>>>()?;
        let n = n_repeats as f64;
        let mean = parts.iter().sum::<f64>() / n;
        let squares: f64 = parts.iter().map(|part| (part - mean) * (part - mean)).sum();
        Some(Self::around(value, (squares * (n - 1.0) / n).sqrt(), n - 1.0))
    }

    /// The mean of independent values, at least two.
    #[must_use]
    pub fn mean(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        Self::around(mean, (squares / (n * (n - 1.0))).sqrt(), n - 1.0)
    }

    fn around(value: f64, error: f64, freedom: f64) -> Self {
        let t = StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |it| it.inverse_cdf(0.975));
        // No error times an infinite t is no error.
        let half = if error > 0.0 { t * error } else { 0.0 };
        Self { value, low: value - half, high: value + half }
    }

    /// Whether a number lies within.
    #[must_use]
    pub fn holds(&self, number: f64) -> bool {
        (self.low..=self.high).contains(&number)
    }
}

/// Refuses what isn't finite, as the value of a robot that blew up.
///
/// # Errors
/// The first such value of any row.
pub fn require_finite(rows: &[Vec<f64>]) -> Result<(), Error> {
    match rows.iter().flatten().find(|value| !value.is_finite()) {
        Some(value) => Err(Error::new("a value of a slice", "a finite number", value)),
        None => Ok(()),
    }
}

pub(crate) fn mean(rows: &[Vec<f64>]) -> Vec<f64> {
    let n = rows.len() as f64;
    sum(rows).iter().map(|sum| sum / n).collect()
}

/// Those rows.
pub(crate) fn chosen(rows: &[Vec<f64>], which: &[usize]) -> Vec<Vec<f64>> {
    which.iter().map(|&r| rows[r].clone()).collect()
}

pub(crate) fn norm(values: &[f64]) -> f64 {
    dot(values, values).sqrt()
}
