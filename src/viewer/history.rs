//! Undo and redo of a value that is edited by dragging: what a drag passes through is not kept, where it ends is.

/// The most states that are kept.
const MOST: usize = 200;

/// A value's past and what was undone of it.
#[derive(Debug, Clone)]
pub struct History<T> {
    past: Vec<T>,
    present: T,
    future: Vec<T>,
}

impl<T: Clone + PartialEq> History<T> {
    /// Begins with a value.
    pub fn new(present: T) -> Self {
        Self {
            past: Vec::new(),
            present,
            future: Vec::new(),
        }
    }

    /// Keeps a value that an edit ended with, if it is another; what was undone is then lost.
    pub fn keep(&mut self, value: &T) {
        if *value == self.present {
            return;
        }
        let before = std::mem::replace(&mut self.present, value.clone());
        self.past.push(before);
        if self.past.len() > MOST {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// The value before the last edit.
    pub fn undo(&mut self) -> Option<T> {
        let before = self.past.pop()?;
        let after = std::mem::replace(&mut self.present, before);
        self.future.push(after);
        Some(self.present.clone())
    }

    /// The value that was undone last.
    pub fn redo(&mut self) -> Option<T> {
        let after = self.future.pop()?;
        let before = std::mem::replace(&mut self.present, after);
        self.past.push(before);
        Some(self.present.clone())
    }

    /// Whether there is something to undo.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Whether there is something to redo.
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undo_goes_back_and_redo_forth_until_something_new_is_done() {
        let mut history = History::new(0);
        for value in [0, 1, 1, 2, 3] {
            history.keep(&value);
        }
        assert_eq!([history.undo(), history.undo()], [Some(2), Some(1)]);
        assert_eq!(history.redo(), Some(2));
        history.keep(&9);
        assert_eq!(history.redo(), None);
        assert_eq!([history.undo(), history.undo()], [Some(2), Some(1)]);
        assert_eq!([history.undo(), history.undo()], [Some(0), None]);
        assert!(!history.can_undo() && history.can_redo());
    }
}
