# fish completion of cansync, cansyncd and cansync-sim. The programs themselves say what may come next, so nothing here
# knows a verb or an option; names of slaves and values come from the running daemon, within half a second.

set -q _cansync_configurations; or set -g _cansync_configurations /etc/cansync # one file for each bus

function __cansync_complete
    set -l words (commandline -opc) # whole words before the cursor, the program first
    set -l program (string replace -r -- '^~' $HOME $words[1])
    type -q $program; or return
    set -l current (commandline -ct)
    # What stands behind an option's '=' is completed by itself; the shell wants the whole word back.
    set -l option (string match -r -- '^-[^=]*=' $current)
    set -l value (string replace -r -- '^-[^=]*=' '' $current)
    for candidate in ($program --complete $words[2..-1] $current 2>/dev/null </dev/null)
        switch $candidate
            case :files
                string replace -r -- '^' "$option" (__fish_complete_path $value)
            case :folders
                string replace -r -- '^' "$option" (__fish_complete_directories $value '')
            case :interfaces
                for path in /sys/class/net/*
                    test -d $path; and printf '%s%s\n' "$option" (string replace -r '.*/' '' $path)
                end
            case :buses
                for path in $_cansync_configurations/*.toml
                    test -f $path; and printf '%s%s\n' "$option" (string replace -r '.*/(.*)\.toml$' '$1' $path)
                end
            case '*'
                printf '%s\n' $candidate
        end
    end
end

for program in cansync cansyncd cansync-sim
    complete -c $program -f -k -a '(__cansync_complete)'
end
