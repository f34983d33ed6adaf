//! Altitudes of a person's landmarks.

use super::measures::Measures;

/// Altitude of the torso, where breadth and depth are measured, as a fraction of the stature (the paper: 151.6 cm of
/// 186.6 cm).
pub const TORSO_ALTITUDE: f64 = 0.8124;

/// \[m\] Altitudes of landmarks, from low to high.
pub(super) struct Heights {
    pub malleolus: f64,
    pub tibial: f64,
    pub knee: f64,
    pub crotch: f64,
    pub buttock: f64,
    pub waist: f64,
    pub rib: f64,
    pub chest: f64,
    pub axilla: f64,
    pub torso: f64,
    pub chin: f64,
    /// The least distance of two landmarks.
    pub step: f64,
}

impl Heights {
    /// Each altitude is at least a little above the one before, for any person.
    pub(super) fn of(m: &Measures) -> Heights {
        let stature = m.person.stature;
        let step = 0.012 * stature / 1.75;
        let torso = TORSO_ALTITUDE * stature;
        let mut floor = 0.0;
        let mut above = |z: f64, gap: f64| {
            floor = z.max(floor + gap * step);
            floor
        };
        // Landmarks below the torso's altitude leave enough room for those between.
        let below = |name: &str, gaps: f64| m.get(name).min(torso - gaps * step);
        Heights {
            malleolus: above(m.get("lateralmalleolusheight"), 3.0),
            tibial: above(m.get("tibialheight"), 8.0),
            knee: above(m.get("kneeheightmidpatella"), 1.0),
            crotch: above(below("crotchheight", 20.0), 10.0),
            buttock: above(below("buttockheight", 17.0), 3.0),
            waist: above(below("waistheightomphalion", 12.0), 4.0),
            rib: above(below("tenthribheight", 9.0), 2.0),
            chest: above(below("chestheight", 6.0), 2.0),
            axilla: above(below("axillaheight", 4.0), 1.0),
            torso,
            // The face: chin to top is 1.77 times tragion to top.
            chin: (stature - 1.77 * m.get("tragiontopofhead")).max(torso + 6.0 * step),
            step,
        }
    }

    /// Returns an altitude at a share of the way from the torso's to the chin.
    pub(super) fn neck(&self, share: f64) -> f64 {
        self.torso + share * (self.chin - self.torso)
    }
}
