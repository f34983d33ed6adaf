//! Index types, so that the compiler distinguishes a disk from a body.

use serde::{Deserialize, Serialize};

macro_rules! index {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub struct $name(pub u32);

        impl $name {
            /// Returns the index as a `usize`.
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl From<usize> for $name {
            #[inline]
            fn from(index: usize) -> Self {
                debug_assert!(index <= u32::MAX as usize);
                $name(index as u32)
            }
        }
    };
}

index!(
    /// Index of a body; bodies are in the order of the agents.
    BodyId
);
index!(
    /// Index of a disk; disks are grouped by body.
    DiskId
);
index!(
    /// Index of a wall.
    WallId
);
index!(
    /// Index of a face; faces are grouped by wall.
    FaceId
);
index!(
    /// Index of a panel; panels are grouped by wall.
    PanelId
);
index!(
    /// Index of a corner, which the faces that meet there share.
    CornerId
);
index!(
    /// Faces that continue each other: the index of the first of them.
    LineId
);
