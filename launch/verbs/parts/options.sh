# The words of a call, judged before anything is installed or compiled: names, files, numbers, choices. Sourced.
#
#   judge VERB OPTION[=KIND]... -- WORD...
#
# sets option_NAME for each OPTION (`-` becomes `_`): `true` for one without KIND, else its value; empty where it is not given.
# Words that are no option become option_word_1, option_word_2, …, and option_words is their number. KIND:
#   number (> 0) · count (a whole number > 0) · whole (a whole number ≥ 0) · scene, device, study (a name or a file; its file becomes
#   option_NAME_file) · file, folder (exists) · output (a file that can be written) · prefix (of files that can be written) · port (exists) ·
#   address (HOST:PORT) · setting (KEY=VALUE) · text · A,B,… (one of these) · a KIND ending in + may be given several times: each
#   value is a line.

judge() {
  local judge_verb judge_known judge_word judge_name judge_kind judge_value
  judge_verb=$1 judge_known='' option_words=0 option_word_1=''
  shift
  while [ "$1" != -- ]; do
    judge_known="$judge_known $1"
    eval "option_$(option_variable "${1%%=*}")='' option_$(option_variable "${1%%=*}")_file=''"
    shift
  done
  shift
  while [ $# -gt 0 ]; do
    judge_word=$1
    shift
    case $judge_word in
      --?*) ;;
      -?*) fail "$judge_verb: unknown option '$judge_word'; $(options_named "$judge_known")" ;;
      *)
        option_words=$((option_words + 1))
        eval "option_word_$option_words=\$judge_word"
        continue ;;
    esac
    judge_name=${judge_word#--}
    judge_kind=$(option_kind "$judge_name" "$judge_known") ||
      fail "$judge_verb: unknown option '$judge_word'; $(options_named "$judge_known")"
    if [ -z "$judge_kind" ]; then
      eval "option_$(option_variable "$judge_name")=true"
      continue
    fi
    [ $# -gt 0 ] || fail "$judge_verb: $judge_word needs a value"
    judge_value=$1
    shift
    [ -n "$judge_value" ] || fail "$judge_verb: $judge_word needs a value, and got an empty one"
    take_option "$judge_verb" "$judge_name" "$judge_kind" "$judge_value"
  done
}

option_variable() {  # NAME
  case $1 in *-*) echo "$1" | tr - _ ;; *) echo "$1" ;; esac
}

option_kind() {  # NAME KNOWN: its kind, empty for a flag; fails where it is unknown
  local each
  for each in $2; do
    case $each in
      "$1") return 0 ;;
      "$1="*) echo "${each#*=}"; return 0 ;;
    esac
  done
  return 1
}

options_named() {  # KNOWN
  local each list
  list=''
  for each in $1; do list="$list${list:+ }--${each%%=*}"; done
  if [ -n "$list" ]; then echo "there are $list"; else echo 'it takes none'; fi
}

take_option() {  # VERB NAME KIND VALUE
  local take_variable take_kind take_file
  take_variable=option_$(option_variable "$2") take_kind=${3%+} take_file=''
  take_file=$(judged_value "$1" "--$2" "$take_kind" "$4") || exit 1
  case $3 in
    *+) eval "$take_variable=\"\${$take_variable}\${$take_variable:+
}\$4\"" ;;
    scene | device | study) eval "$take_variable=\$4 ${take_variable}_file=\$take_file" ;;
    *) eval "$take_variable=\$4" ;;
  esac
}

# One line and exit code 1 where a value is not of its kind. Prints the file of a scene, device or study.
judged_value() {  # VERB WHAT KIND VALUE
  case $3 in
    number) is_number "$4" || fail "$1: $2 '$4' is not a number > 0" ;;
    count) { is_whole "$4" && [ -n "$(printf %s "$4" | tr -d 0)" ]; } || fail "$1: $2 '$4' is not a whole number > 0" ;;
    whole) is_whole "$4" || fail "$1: $2 '$4' is not a whole number" ;;
    scene) case $4 in param:*) ;; *) find_scene "$4" ;; esac ;;
    device) find_device "$4" ;;
    study) find_study "$4" ;;
    file) [ -f "$(absolute "$4")" ] || fail "$1: $2 '$4': no such file" ;;
    folder) [ -d "$(absolute "$4")" ] || fail "$1: $2 '$4': no such folder" ;;
    output) can_be_written "$1: $2" "$4" "$(absolute "$4")" ;;
    prefix) can_be_written "$1: $2" "$4" "$(absolute "$4").part" ;;
    port) [ -e "$(absolute "$4")" ] || fail "$1: $2 '$4': no such port; is the device connected? 'ls /dev/ttyUSB* /dev/ttyACM*' shows the ports here" ;;
    address) { [ -n "${4%:*}" ] && [ "${4%:*}" != "$4" ] && is_whole "${4##*:}"; } || fail "$1: $2 '$4' is no address HOST:PORT" ;;
    setting) case $4 in ?*=*) ;; *) fail "$1: $2 '$4' is not KEY=VALUE" ;; esac ;;
    text) ;;
    *) case ",$3," in *",$4,"*) ;; *) fail "$1: $2 '$4' is none of $(echo "$3" | sed 's/,/, /g')" ;; esac ;;
  esac
}

is_whole() { case $1 in '' | *[!0-9]*) return 1 ;; esac; }  # TEXT

# root may write where a disk is read-only, or so the permissions say: only writing tells.
can_be_written() {  # WHAT VALUE PATH
  [ -d "$(dirname "$3")" ] || fail "$1 '$2': no such folder"
  [ ! -d "$3" ] || fail "$1 '$2' is a folder"
  (: >"$3.$$") 2>/dev/null || fail "$1 '$2' cannot be written: give a folder that is writable"
  rm -f "$3.$$"
}

at_most() {  # NUMBER VERB WHAT: refuses words beyond those that the verb takes
  local most_word
  [ "$option_words" -gt "$1" ] || return 0
  eval "most_word=\$option_word_$(($1 + 1))"
  fail "$2: unexpected '$most_word'; it takes $3"
}
