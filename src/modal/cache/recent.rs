//! A small list of results with the keys from which they follow.

use std::convert::Infallible;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Number of results that are kept by default. A parameter study asks repeatedly for a few speeds.
const DEFAULT_CAPACITY: usize = 8;

/// The last `CAPACITY` results, the one that was used last at the end.
#[derive(Debug)]
pub struct Recent<K, V, const CAPACITY: usize = DEFAULT_CAPACITY>(Mutex<Vec<(K, V)>>);

impl<K, V, const CAPACITY: usize> Default for Recent<K, V, CAPACITY> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: PartialEq, V: Clone, const CAPACITY: usize> Recent<K, V, CAPACITY> {
    /// The result of a key, if it is known.
    pub fn get(&self, key: &K) -> Option<V> {
        let mut list = self.lock();
        let index = list.iter().rposition(|(known, _)| known == key)?;
        let entry = list.remove(index);
        let value = entry.1.clone();
        list.push(entry);
        Some(value)
    }

    /// The result of a key, if it is known; otherwise the result of `compute`, which is kept if it is not an error.
    ///
    /// # Errors
    /// Those of `compute`.
    pub fn get_or_try<E>(&self, key: K, compute: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        if let Some(known) = self.get(&key) {
            return Ok(known);
        }
        let found = compute()?;
        self.insert(key, found.clone());
        Ok(found)
    }

    /// The result of a key, if it is known; otherwise the result of `compute`, which is kept.
    pub fn get_or(&self, key: K, compute: impl FnOnce() -> V) -> V {
        self.get_or_try(key, || Ok::<V, Infallible>(compute())).unwrap_or_else(|never| match never {})
    }

    /// Keeps a result; the one that was not used for the longest time makes room.
    pub fn insert(&self, key: K, value: V) {
        let mut list = self.lock();
        if list.len() >= CAPACITY {
            list.remove(0);
        }
        list.push((key, value));
    }

    fn lock(&self) -> MutexGuard<'_, Vec<(K, V)>> {
        // A panic in another thread cannot leave the list half-written, so a poisoned lock is safe to use.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::{DEFAULT_CAPACITY as CAPACITY, Recent};

    #[test]
    fn the_least_recently_used_result_makes_room() {
        let recent = Recent::<usize, usize>::default();
        (0..CAPACITY).for_each(|key| recent.insert(key, 10 * key));
        assert_eq!(recent.get(&0), Some(0));
        recent.insert(CAPACITY, 1);
        assert_eq!([recent.get(&0), recent.get(&1), recent.get(&CAPACITY)], [Some(0), None, Some(1)]);
    }
}
