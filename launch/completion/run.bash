# Completion of ./run for bash: `. launch/completion/run.bash`, or copy it to /etc/bash_completion.d.
_haptic_run() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} verb=${COMP_WORDS[1]} root words
  root=$(dirname "$(readlink -f "${COMP_WORDS[0]/#\~/$HOME}" 2>/dev/null)") || return
  [ -d "$root/launch/verbs" ] || return
  _haptic_names() { find "$root/$1" -maxdepth 1 \( -name '*.urdf' -o -name '*.yaml' \) -printf '%f\n' 2>/dev/null | sed 's/\.[a-z]*$//'; }
  if [ "$COMP_CWORD" = 1 ]; then
    words="$(find "$root/launch/verbs" -maxdepth 1 -name '*.sh' ! -name version.sh -printf '%f\n' | sed 's/\.sh$//') help --version"
  elif [ "$before" = --scene ]; then
    words=$(_haptic_names urdf/scenes)
  elif [ "$before" = --device ]; then
    words="$(_haptic_names urdf/devices) uart"
  elif [ "$before" = --sanitize ]; then
    words='address undefined thread'
  elif [[ $word == -* ]]; then
    words="$(sed -n 's/^#: //p' "$root/launch/verbs/$verb.sh" 2>/dev/null | grep -o -e '--[a-z-]*' | sort -u) --help"
  else
    case $verb in
      check) words="$(_haptic_names urdf/scenes) $(_haptic_names urdf/devices) $(_haptic_names urdf/experiments)" ;;
      experiment) words=$(_haptic_names urdf/experiments) ;;
      report) words=$(_haptic_names urdf/scenes) ;;
      bench) words="$(find "$root/test/benchmark" -name '*_bench.cpp' -printf '%f\n' 2>/dev/null | sed 's/_bench\.cpp$//') python" ;;
      setup) words=$(sed -n 's/^## \([a-z]*\): .*/\1/p' "$root/packages.apt" 2>/dev/null) ;;
    esac
  fi
  unset -f _haptic_names
  local files=no  # where a path may stand
  case $verb in analyse | check | demo | experiment | export | replay | report | shrink) [[ $COMP_CWORD = 1 || $word == -* ]] || files=yes ;; esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word"; [ "$files" = no ] || compgen -f -- "$word")
}
complete -o filenames -F _haptic_run run ./run
