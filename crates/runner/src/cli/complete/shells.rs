//! Scripts of bash and zsh in place of the library's own, for what cells and settings have in them: a `=`,
//! at which bash cuts a word, and behind which zsh would begin another one.

use std::{
    ffi::OsString,
    io::{self, Write},
    path::Path,
};

use clap_complete::env::{self, EnvCompleter};

/// A shell that the library knows, with a script of ours.
pub(super) struct Scripted {
    shell: &'static dyn EnvCompleter,
    script: &'static str,
}

/// The cut words are put together again, and of the answers that's cut off which the shell has as words
/// of their own.
pub(super) const BASH: Scripted = Scripted {
    shell: &env::Bash,
    script: r#"_NAME() {
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
"#,
};

/// What ends in a `=` or a `/` goes on.
pub(super) const ZSH: Scripted = Scripted {
    shell: &env::Zsh,
    script: r#"#compdef BINARY
function _NAME() {
    local -a all open whole
    local it
    all=("${(@f)$(VARIABLE=zsh _CLAP_IFS=$'\n' _CLAP_COMPLETE_INDEX=$((CURRENT - 1)) \
        PROGRAM -- "${words[@]}" 2>/dev/null)}")
    for it in $all; do
        # A value, and behind a colon what it is.
        if [[ "${it%%:*}" == *[=/] ]]; then open+=("$it"); else whole+=("$it"); fi
    done
    [[ -n $open ]] && _describe -V 'values' open -S ''
    [[ -n $whole ]] && _describe -V 'values' whole
}
compdef _NAME BINARY
"#,
};

impl EnvCompleter for Scripted {
    fn name(&self) -> &'static str {
        self.shell.name()
    }

    fn is(&self, name: &str) -> bool {
        self.shell.is(name)
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
        let script = self.script.replace("VARIABLE", variable).replace("NAME", name);
        out.write_all(script.replace("BINARY", binary).replace("PROGRAM", &quoted).as_bytes())
    }

    fn write_complete(
        &self,
        command: &mut clap::Command,
        words: Vec<OsString>,
        folder: Option<&Path>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        self.shell.write_complete(command, words, folder, out)
    }
}
