//! What the information in the reward is called: as its kind calls it, or what several kinds have in
//! common.

/// The information in the reward, with its name on axes and in tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Information {
    /// What it is, in words: the kind, as experiment files call it.
    pub what: String,
    /// Its symbol, `R_MI`.
    pub symbol: String,
    /// Its unit, nats.
    pub unit: String,
    /// What it's the mean over, as in nats per variable; none where that differs.
    pub per: Option<String>,
}

impl Information {
    /// That of one kind: its name, its symbol, its unit, and what it's the mean over.
    #[must_use]
    pub fn of_kind(what: &str, symbol: &str, [unit, per]: [&str; 2]) -> Self {
        let [what, symbol, unit, per] =
            [&what.replace('_', " "), symbol, unit, per].map(str::to_owned);
        Self { what, symbol, unit, per: Some(per) }
    }

    /// That of several kinds, in this unit.
    #[must_use]
    pub fn common(unit: &str) -> Self {
        let [what, unit] = ["information", unit].map(str::to_owned);
        Self { symbol: what.clone(), what, unit, per: None }
    }

    /// `mutual information R_MI`; `information`, where that's its symbol, too.
    #[must_use]
    pub fn name(&self) -> String {
        named(&self.what, &self.symbol)
    }

    /// Its symbol and its unit, the head of a column: `R_MI nats`.
    #[must_use]
    pub fn heading(&self) -> String {
        format!("{} {}", self.symbol, self.unit)
    }

    /// The unit beside an axis: `nats per variable`.
    #[must_use]
    pub fn axis_unit(&self) -> String {
        match &self.per {
            Some(per) => format!("{} per {per}", self.unit),
            None => self.unit.clone(),
        }
    }
}

/// A word with its symbol, unless they're the same.
pub(super) fn named(what: &str, symbol: &str) -> String {
    match what == symbol {
        true => symbol.to_owned(),
        false => format!("{what} {symbol}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn information_is_called_as_its_kind_calls_it() {
        let flow = Information::of_kind("transfer_entropy", "R_TE", ["nats", "link"]);
        assert_eq!([flow.name(), flow.axis_unit()], ["transfer entropy R_TE", "nats per link"]);
        let both = Information::common("nats");
        assert_eq!([both.name(), both.axis_unit()], ["information", "nats"]);
    }
}
