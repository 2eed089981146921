//! What every distribution function promises, tested over one list of cases ([`cases`]).
//!
//! Nothing here knows a lobe by name: a new lobe gets one entry in the list, without which this does not
//! compile, and inherits every test.

mod agreement;
mod albedo;
mod auxiliary;
mod cases;
mod chi_square;
mod corners;
mod emission;
mod energy;
mod film;
mod fresnel;
mod hair;
mod limits;
mod math;
mod measured;
mod optional;
mod reciprocity;
mod sphere;
mod text;
mod volume;

/// `f` of every item, on all cores, in order.
fn parallel<T: Sync, R: Send>(items: &[T], f: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = std::sync::atomic::AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut results: Vec<(usize, R)> = std::thread::scope(|scope| {
        let work = || {
            let mut done = Vec::new();
            loop {
                let index = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                match items.get(index) {
                    Some(item) => done.push((index, f(item))),
                    None => return done,
                }
            }
        };
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        handles.into_iter().flat_map(|handle| handle.join().expect("a check panicked")).collect()
    });
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
