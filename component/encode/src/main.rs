//! Makes a component of a core module whose interface is in its custom sections: `encode-component MODULE COMPONENT`.

use std::error::Error;
use wit_component::ComponentEncoder;

fn main() -> Result<(), Box<dyn Error>> {
    let [module, component] = std::env::args()
        .skip(1)
        .collect::<Vec<_>>()
        .try_into()
        .map_err(|_| "usage: encode-component MODULE COMPONENT")?;
    let bytes = ComponentEncoder::default().validate(true).module(&std::fs::read(module)?)?.encode()?;
    Ok(std::fs::write(component, bytes)?)
}
