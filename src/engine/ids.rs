//! Index newtypes: a disk is never a body.

use serde::{Deserialize, Serialize};

macro_rules! index {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub struct $name(pub u32);

        impl $name {
            /// As a place in an array.
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
    /// A body: place among the agents.
    BodyId
);
index!(
    /// A disk: place among all disks, grouped by body.
    DiskId
);
index!(
    /// A wall: place among the walls.
    WallId
);
index!(
    /// A face: place among all faces, grouped by wall.
    FaceId
);
index!(
    /// A corner shared by faces of one wall.
    CornerId
);
index!(
    /// Faces that go on straight into each other: place of one of them.
    LineId
);
