//! When a stage is worth more than one thread.

/// Estimated cost below which a stage stays on one thread, ns: about what waking a sleeping thread takes (an estimate,
/// not measured here), and the step waits for a thread that was woken and put aside by a busy process.
const WORTH_WAKING: usize = 40_000;

/// Whether `items` of about `ns_each` should be shared among threads. Results never depend on the answer: chunks and
/// the order of sums stay as they are.
pub(crate) fn worthwhile(items: usize, ns_each: usize) -> bool {
    items * ns_each >= WORTH_WAKING && rayon::current_num_threads() > 1
}

/// Smallest piece for rayon to split off: `chunk`, or everything where sharing does not pay.
pub(crate) fn least(items: usize, chunk: usize, ns_each: usize) -> usize {
    if worthwhile(items, ns_each) { chunk } else { items.max(1) }
}
