//! Headers of shared libraries, with nothing behind them.

/// Of a library for Windows on x86-64.
pub fn pe() -> Vec<u8> {
    let mut bytes = vec![0; 512];
    bytes[..2].copy_from_slice(b"MZ");
    bytes[60] = 64;
    bytes[64..70].copy_from_slice(b"PE\0\0\x64\x86");
    // The size and the magic of the optional header.
    bytes[84] = 240;
    bytes[88..90].copy_from_slice(&[0x0b, 0x02]);
    bytes
}
