//! Reduces a trace to fewer points than rows, without losing a peak.

/// Extremes of a signal within a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// Point with the smallest value.
    pub(super) min: (f64, f64),
    /// Point with the largest value.
    pub(super) max: (f64, f64),
}

/// Divides the points into `count` stretches of equal number and returns the extremes of each. NaN is left
/// out.
pub(super) fn extents(points: &[(f64, f64)], count: usize) -> Vec<Extent> {
    let per_stretch = points.len().div_ceil(count.max(1)).max(1);
    points.chunks(per_stretch).filter_map(extent).collect()
}

/// Returns a line through the extremes of at most `count` stretches; all the points if there are few.
pub(super) fn line(points: &[(f64, f64)], count: usize) -> Vec<(f64, f64)> {
    if points.len() <= 2 * count {
        return without_repeats(points.iter().copied().filter(|(_, y)| !y.is_nan()));
    }
    without_repeats(
        extents(points, count).into_iter().flat_map(
            |Extent { min, max }| {
                if min.0 <= max.0 { [min, max] } else { [max, min] }
            },
        ),
    )
}

/// Returns the mean of each of `count` stretches.
pub(super) fn means(points: &[(f64, f64)], count: usize) -> Vec<(f64, f64)> {
    let per_stretch = points.len().div_ceil(count.max(1)).max(1);
    let mean = |points: &[(f64, f64)]| {
        let count = points.len() as f64;
        let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0, y + point.1));
        (x / count, y / count)
    };
    without_repeats(points.chunks(per_stretch).map(mean).filter(|(_, y)| !y.is_nan()))
}

fn extent(points: &[(f64, f64)]) -> Option<Extent> {
    let mut numbers = points.iter().copied().filter(|(_, y)| !y.is_nan());
    let first = numbers.next()?;
    let start = Extent { min: first, max: first };
    Some(numbers.fold(start, |Extent { min, max }, point| Extent {
        min: if point.1 < min.1 { point } else { min },
        max: if point.1 >= max.1 { point } else { max },
    }))
}

/// Removes points in the middle of a level stretch.
fn without_repeats(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if let [.., before, last] = kept.as_mut_slice()
            && before.1 == last.1
            && last.1 == point.1
        {
            *last = point;
            continue;
        }
        kept.push(point);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_peak_is_lost() {
        let mut points: Vec<(f64, f64)> = (0..30_000).map(|k| (f64::from(k), 0.0)).collect();
        points[12_345].1 = 9.0;
        points[23_456].1 = -7.0;
        let line = line(&points, 900);
        assert!(line.len() <= 1_800);
        assert!(line.iter().any(|(_, y)| *y == 9.0) && line.iter().any(|(_, y)| *y == -7.0));
        assert_eq!(line.first().unwrap().1, 0.0);
        // Level stretches need almost no points.
        assert!(line.len() < 20, "{}", line.len());
    }

    #[test]
    fn few_points_stay_as_they_are() {
        let points: Vec<(f64, f64)> = (0..50).map(|k| (f64::from(k), f64::from(k % 7))).collect();
        assert_eq!(line(&points, 100), points);
        assert!(line(&[], 100).is_empty());
        assert!(extents(&[(0.0, f64::NAN)], 100).is_empty());
        assert_eq!(means(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0), (3.0, 7.0)], 2), [(0.5, 2.0), (2.5, 6.0)]);
    }
}
