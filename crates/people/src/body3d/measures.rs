//! The mean body of each sex, and how its measures follow the four of a person.

use crate::person::Sex;
use std::sync::LazyLock;

/// A measure that follows from the four given measures of a person, in the order of data/bodies.txt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    /// \[m\] height of the bony tip of the shoulder: `acromialheight`.
    AcromialHeight,
    /// \[m\] height of the armpit: `axillaheight`.
    AxillaHeight,
    /// \[m\] height of the nipples: `chestheight`.
    ChestHeight,
    /// \[m\] height of the lowest rib: `tenthribheight`.
    TenthRibHeight,
    /// \[m\] height of the navel: `waistheightomphalion`.
    WaistHeight,
    /// \[m\] height of the most prominent point of the buttocks: `buttockheight`.
    ButtockHeight,
    /// \[m\] height of the crotch: `crotchheight`.
    CrotchHeight,
    /// \[m\] height of the middle of the kneecap: `kneeheightmidpatella`.
    KneeHeight,
    /// \[m\] height of the top of the shinbone: `tibialheight`.
    TibialHeight,
    /// \[m\] height of the outer ankle bone: `lateralmalleolusheight`.
    MalleolusHeight,
    /// \[m\] height of the wrist: `wristheight`.
    WristHeight,
    /// \[m\] from the ear's notch up to the top of the head: `tragiontopofhead`.
    TragionToTop,
    /// \[m\] from the shoulder's tip to the elbow: `acromionradialelength`.
    UpperArmLength,
    /// \[m\] from the wrist to the fingertip: `handlength`.
    HandLength,
    /// \[m\] between the tips of the shoulders: `biacromialbreadth`.
    BiacromialBreadth,
    /// \[m\] at the nipples: `chestbreadth`.
    ChestBreadth,
    /// \[m\] at the navel: `waistbreadth`.
    WaistBreadth,
    /// \[m\] at the navel: `waistdepth`.
    WaistDepth,
    /// \[m\] widest of the hips: `hipbreadth`.
    HipBreadth,
    /// \[m\] at the buttocks: `buttockdepth`.
    ButtockDepth,
    /// \[m\] widest above the ears: `headbreadth`.
    HeadBreadth,
    /// \[m\] from the brow to the back of the head: `headlength`.
    HeadLength,
    /// \[m\] heel to toe: `footlength`.
    FootLength,
    /// \[m\] widest of the foot: `footbreadthhorizontal`.
    FootBreadth,
    /// \[m\] across the knuckles: `handbreadth`.
    HandBreadth,
    /// \[m\] at the nipples: `chestcircumference`.
    ChestGirth,
    /// \[m\] at the navel: `waistcircumference`.
    WaistGirth,
    /// \[m\] at the buttocks: `buttockcircumference`.
    ButtockGirth,
    /// \[m\] above the brow: `headcircumference`.
    HeadGirth,
    /// \[m\] at the larynx: `neckcircumference`.
    NeckGirth,
    /// \[m\] at the root of the neck: `neckcircumferencebase`.
    NeckBaseGirth,
    /// \[m\] flexed: `bicepscircumferenceflexed`.
    BicepsGirth,
    /// \[m\] flexed: `forearmcircumferenceflexed`.
    ForearmGirth,
    /// \[m\] at the wrist: `wristcircumference`.
    WristGirth,
    /// \[m\] just below the buttocks: `thighcircumference`.
    ThighGirth,
    /// \[m\] just above the kneecap: `lowerthighcircumference`.
    LowerThighGirth,
    /// \[m\] widest of the calf: `calfcircumference`.
    CalfGirth,
    /// \[m\] narrowest above the ankle: `anklecircumference`.
    AnkleGirth,
}

/// Number of variants of [`Measure`].
pub(super) const COUNT: usize = 38;

/// The mean body of one sex.
pub(super) struct MeanBody {
    /// \[m, m, m, kg\] means of bideltoid breadth, chest depth, stature, mass.
    pub given: [f64; 4],
    /// For each measure: mean \[m\], then its slopes with respect to the four given ones.
    pub measures: [[f64; 5]; COUNT],
}

/// The table that `data/body_measures.py` made from the survey ANSUR II.
pub(super) const TABLE: &str = include_str!("../../data/bodies.txt");

pub(super) fn mean_body(sex: Sex) -> &'static MeanBody {
    static BODIES: LazyLock<[MeanBody; 2]> = LazyLock::new(|| {
        parse(TABLE).expect("the committed data file is whole, every test of bodies reads it")
    });
    &BODIES[sex as usize]
}

/// Each line: a name, then numbers.
fn parse(text: &str) -> Option<[MeanBody; 2]> {
    let numbers = |line: &str| -> Option<Vec<f64>> {
        line.split(' ').skip(1).map(|number| number.parse().ok()).collect()
    };
    let mut rows = text.lines().filter(|line| !line.starts_with('#')).map(numbers);
    let mut body = || {
        let given = rows.next()??.try_into().ok()?;
        let measures: Option<Vec<[f64; 5]>> =
            rows.by_ref().take(COUNT).map(|row| row.and_then(|row| row.try_into().ok())).collect();
        Some(MeanBody { given, measures: measures?.try_into().ok()? })
    };
    Some([body()?, body()?])
}
