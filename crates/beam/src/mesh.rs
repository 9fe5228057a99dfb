//! Where the nodes are: close together where the column yields, further apart between.

/// Elements over the depth of the section at base, impact and top.
const PER_DEPTH: f64 = 5.0;

/// How an element may grow per distance from there, and how large it may become over the length of the column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Density {
    growth: f64,
    largest: f64,
}

/// For a hit in space, which costs six times as much per element and is compared within 3 %.
pub(crate) const COARSEST: Density = Density {
    growth: 1.0,
    largest: 1.0 / 8.0,
};

/// For a rigid vehicle, whose energy the column must take in any case.
pub(crate) const COARSE: Density = Density {
    growth: 0.5,
    largest: 1.0 / 12.0,
};

/// For one that crushes: near the force at which the column yields, a little strength decides on large displacements.
pub(crate) const FINE: Density = Density {
    growth: 0.25,
    largest: 1.0 / 24.0,
};

/// Heights of the nodes \[m\]. `keys` are places that get a node, in rising order from the base to the top; about `count`
/// elements in all, or as many as the rule gives if 0.
pub(crate) fn nodes(keys: &[f64], depth: f64, count: usize, density: Density) -> Vec<f64> {
    let length = keys[keys.len() - 1];
    // Elements are as long as their mean size, so that the first one is longer than the size at its beginning.
    let first = depth / PER_DEPTH * density.growth / libm::expm1(density.growth);
    let size = |x: f64| {
        let near = keys.iter().map(|key| (key - x).abs());
        let distance = near.fold(f64::INFINITY, f64::min);
        (first + density.growth * distance).min(length * density.largest)
    };
    // How many elements fit between two places, by the middle of fine parts.
    const PARTS: usize = 400;
    let fits = |from: f64, to: f64| {
        let part = (to - from) / PARTS as f64;
        (0..PARTS)
            .map(|k| part / size(from + (k as f64 + 0.5) * part))
            .sum::<f64>()
    };
    let all: f64 = keys.windows(2).map(|pair| fits(pair[0], pair[1])).sum();
    let scale = if count == 0 { 1.0 } else { count as f64 / all };
    let mut nodes = vec![keys[0]];
    for pair in keys.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let total = fits(from, to);
        let elements = (libm::ceil(scale * total) as usize).max(1);
        let part = (to - from) / PARTS as f64;
        let (mut sum, mut next) = (0.0, 1);
        for k in 0..PARTS {
            let step = part / size(from + (k as f64 + 0.5) * part);
            while next < elements && sum + step >= total * next as f64 / elements as f64 {
                let share = (total * next as f64 / elements as f64 - sum) / step;
                nodes.push(from + part * (k as f64 + share));
                next += 1;
            }
            sum += step;
        }
        nodes.push(to);
    }
    nodes
}

/// The node nearest to a height.
pub(crate) fn nearest(heights: &[f64], x: f64) -> usize {
    let distance = |height: &f64| (height - x).abs();
    let nearest = heights
        .iter()
        .enumerate()
        .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
    nearest.map_or(0, |(node, _)| node)
}
