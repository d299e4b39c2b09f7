//! Where slices go through a space of parameters.
//!
//! A random direction is scaled block by block,
//!
//! ```text
//! d_b = |theta_b| / |n_b| n_b,   n of N(0,1)
//! ```
//!
//! so that a step of 1 changes every block by as much as it has: the filter-normalised directions of H.
//! Li et al., *Visualizing the loss landscape of neural nets*, NeurIPS 2018. Else a policy with larger
//! weights looks smoother than one with smaller ones that does the same. From there is the plane of a
//! training path, too: that of the two largest principal components of theta_k - theta_last.

use nalgebra::{DMatrix, SymmetricEigen};
use streams::Normals;

use crate::{inner::dot, repeats::norm};

/// A random direction at `centre`, `[n_parameters]`, scaled by these blocks, each a list of parameters; a
/// parameter in none of them doesn't change. The same seed and name give the same one.
#[must_use]
pub fn random_direction(centre: &[f64], blocks: &[Vec<usize>], seed: u64, name: &str) -> Vec<f64> {
    let mut normals = Normals::new(seed, name);
    let mut direction: Vec<f64> = centre.iter().map(|_| normals.draw()).collect();
    let mut scale = vec![0.0; centre.len()];
    for block in blocks {
        let of = |vector: &[f64]| norm(&block.iter().map(|&i| vector[i]).collect::<Vec<_>>());
        let factor = of(centre) / of(&direction);
        block.iter().for_each(|&i| scale[i] = factor);
    }
    direction.iter_mut().zip(scale).for_each(|(value, scale)| *value *= scale);
    direction
}

/// Blocks of parameters, each of a bias with the weights whose bias it is; what has no such bias is one
/// block more. `links` are weights with their biases.
#[must_use]
pub fn blocks(
    n_parameters: usize,
    links: impl Iterator<Item = (usize, Option<usize>)>,
) -> Vec<Vec<usize>> {
    let mut of: Vec<usize> = (0..n_parameters).collect();
    let mut has_weights = vec![false; n_parameters];
    for (weight, bias) in links {
        if let Some(bias) = bias {
            of[weight] = bias;
            has_weights[weight] = true;
            has_weights[bias] = true;
        }
    }
    let mut blocks = vec![Vec::new(); n_parameters + 1];
    for (parameter, &block) in of.iter().enumerate() {
        let block = if has_weights[parameter] { block } else { n_parameters };
        blocks[block].push(parameter);
    }
    blocks.retain(|block| !block.is_empty());
    blocks
}

/// The plane that a path lies in as far as it lies in one.
#[derive(Clone, Debug, PartialEq)]
pub struct PrincipalPlane {
    /// Two directions, orthogonal, each as long as the path reaches along it: `[2][n_parameters]`.
    pub directions: [Vec<f64>; 2],
    /// The path's points in units of these, the last one at the origin: `[n_points]`.
    pub path: Vec<[f64; 2]>,
    /// The share of the path's squared extent in the plane, 0 to 1.
    pub share: f64,
}

impl PrincipalPlane {
    /// The plane of a path, `[n_points x n_parameters]`; none if it has fewer than three points or lies in a line.
    #[must_use]
    pub fn of(path: &[Vec<f64>]) -> Option<Self> {
        let last = path.last()?;
        let steps: Vec<Vec<f64>> =
            path.iter().map(|point| point.iter().zip(last).map(|(a, b)| a - b).collect()).collect();
        let n = steps.len();
        // The eigenvectors of the points' inner products are the points' places along the components.
        let gram = DMatrix::from_fn(n, n, |i, j| dot(&steps[i], &steps[j]));
        let eigen = SymmetricEigen::new(gram.clone());
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let along = |rank: usize| {
            let k = *order.get(rank)?;
            let value = eigen.eigenvalues[k];
            if value <= 1e-12 * gram.trace() || value <= 0.0 {
                return None;
            }
            let weights: Vec<f64> = eigen.eigenvectors.column(k).iter().copied().collect();
            Some((Component::of(&steps, &weights), value))
        };
        let [(first, a), (second, b)] = [along(0)?, along(1)?];
        let path = first.places.iter().zip(&second.places).map(|(a, b)| [*a, *b]).collect();
        let directions = [first.direction, second.direction];
        Some(Self { directions, path, share: (a + b) / gram.trace() })
    }
}

/// A direction as long as the path reaches along it, with the path's places in units of it.
struct Component {
    direction: Vec<f64>,
    places: Vec<f64>,
}

impl Component {
    fn of(steps: &[Vec<f64>], weights: &[f64]) -> Self {
        let mut direction = vec![0.0; steps[0].len()];
        for (step, weight) in steps.iter().zip(weights) {
            direction.iter_mut().zip(step).for_each(|(sum, value)| *sum += weight * value);
        }
        let length = norm(&direction);
        let places: Vec<f64> = steps.iter().map(|step| dot(step, &direction) / length).collect();
        // The path begins on the positive side, whatever sign an eigenvector has.
        let sign = if places[0] < 0.0 { -1.0 } else { 1.0 };
        let reach = sign * places.iter().fold(0.0, |most: f64, place| most.max(place.abs()));
        Self {
            direction: direction.iter().map(|value| value / length * reach).collect(),
            places: places.iter().map(|place| place / reach).collect(),
        }
    }
}
