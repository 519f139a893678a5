//! What the papers measured that the project started from, each on the hardware of its day. Ratios are what can be compared.

/// Yu et al. 2016: one data set of 256 x 256 x 256 voxels, milliseconds of the kernel on a `GeForce GT 635M`.
pub(super) struct Split {
    /// Steps in parts of the cube's edge, as the command takes them, with the times of Westermann's method (box), the
    /// octree-encoded one and half-splitting.
    pub(super) steps: [(&'static str, [f64; 3]); 3],
    /// Preprocessing of the same three methods, reading the volume included.
    pub(super) preprocess_ms: [f64; 3],
}

/// The methods of those columns.
pub(super) const SPLIT_METHODS: [&str; 3] = ["box", "octree-encoded", "half-split"];

/// Tables 1 and 3.
pub(super) const TEAPOT: Split = Split {
    steps: [
        ("0.002u", [6.439, 4.545, 3.628]),
        ("0.005u", [2.943, 2.240, 1.807]),
        ("0.01u", [1.685, 1.335, 1.147]),
    ],
    preprocess_ms: [200.0, 820.0, 785.0],
};

/// Tables 1 and 2.
pub(super) const FOOT: Split = Split {
    steps: [
        ("0.002u", [4.629, 4.250, 4.210]),
        ("0.005u", [2.973, 2.732, 2.748]),
        ("0.01u", [1.728, 1.688, 1.646]),
    ],
    preprocess_ms: [205.0, 830.0, 800.0],
};

/// The ray caster in CUDA of the project's second source, table 1: pictures per second of a head (256 x 256 x 225) and a
/// heart (256^3) at 512x512 on a `GeForce 9600GT`, by what is the same mode here.
pub(super) const MODES: [(&str, [f64; 2]); 6] = [
    ("emission-absorption", [37.34, 38.79]),
    ("grey", [56.54, 55.87]),
    ("mip", [62.82, 63.91]),
    ("normals", [64.66, 62.24]),
    ("phong", [57.64, 53.89]),
    ("two-surfaces", [52.92, 51.76]),
];

/// The line of real time in the third source's chart of frame time over volume size, in ms.
pub(super) const REAL_TIME_MS: f64 = 20.0;
