//! Options that do not exist: which one is probably meant.

use clap::Command;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use lemons_core::files::words::meant;

/// Replaces the tip of an error about an unknown option of a command. That of clap is any option that shares letters
/// with it, or to take it for a file.
pub fn with_tip(mut error: Error, command: Option<&mut Command>) -> Error {
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) else { return error };
    let (ErrorKind::UnknownArgument, Some(given), Some(command)) =
        (error.kind(), given.strip_prefix("--").map(str::to_owned), command)
    else {
        return error;
    };
    let options = command.get_arguments().filter(|option| !option.is_hide_set());
    let tip =
        meant(&given, options.filter_map(|option| option.get_long())).map(|option| format!("--{option}"));
    error.remove(ContextKind::SuggestedArg);
    error.remove(ContextKind::Suggested);
    // It shows clap's tip, too.
    error.insert(ContextKind::Usage, ContextValue::StyledStr(command.render_usage()));
    if let Some(option) = tip {
        error.insert(ContextKind::SuggestedArg, ContextValue::String(option));
    }
    error
}
