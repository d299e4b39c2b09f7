//! Completions in bash, which takes a `=` for the end of a word: those of cells and of settings have some
//! in them.

use std::{
    ffi::OsString,
    io::{self, Write},
    path::Path,
};

use clap_complete::env::{self, EnvCompleter};

/// The cut words are put together again, and of the answers that's cut off which the shell has as
/// words of their own.
const SCRIPT: &str = r#"_NAME() {
    local IFS=$'\013' words=() last= word i
    for ((i = 0; i <= COMP_CWORD; i++)); do
        word=${COMP_WORDS[i]}
        # Up to the cursor.
        [[ $i -lt $COMP_CWORD || $word == [=:] ]] || word=$2
        if [[ $i -gt 0 && ($word == [=:] || $last == *[=:]) && $COMP_LINE == *"$last$word"* ]]; then
            last+=$word
            words[${#words[@]}-1]=$last
        else
            last=$word
            words+=("$word")
        fi
    done
    COMPREPLY=($(VARIABLE=bash _CLAP_IFS="$IFS" _CLAP_COMPLETE_INDEX=$((${#words[@]} - 1)) \
        PROGRAM -- "${words[@]}" 2>/dev/null))
    COMPREPLY=("${COMPREPLY[@]#"${last%"$2"}"}")
    if [[ ${COMPREPLY-} == *[=/:] ]]; then
        compopt -o nospace 2>/dev/null
    fi
}
complete -o bashdefault -o nosort -F _NAME BINARY 2>/dev/null || complete -o bashdefault -F _NAME BINARY
"#;

pub(super) struct Bash;

impl EnvCompleter for Bash {
    fn name(&self) -> &'static str {
        env::Bash.name()
    }

    fn is(&self, name: &str) -> bool {
        env::Bash.is(name)
    }

    fn write_registration(
        &self,
        variable: &str,
        name: &str,
        binary: &str,
        program: &str,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let quoted = format!("'{}'", program.replace('\'', r"'\''"));
        let script = SCRIPT.replace("VARIABLE", variable).replace("NAME", name);
        out.write_all(script.replace("BINARY", binary).replace("PROGRAM", &quoted).as_bytes())
    }

    fn write_complete(
        &self,
        command: &mut clap::Command,
        words: Vec<OsString>,
        folder: Option<&Path>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        env::Bash.write_complete(command, words, folder, out)
    }
}
