# Written by tools/share.py; change the code, not this file.
# The functions are made of a template of Click, Copyright 2014 Pallets, BSD-3-Clause.
function _slewline_completion;
    set -l response (env _SLEWLINE_COMPLETE=fish_complete COMP_WORDS=(commandline -cp) COMP_CWORD=(commandline -t) slewline);

    for completion in $response;
        set -l metadata (string split "," $completion);

        if test $metadata[1] = "dir";
            __fish_complete_directories $metadata[2];
        else if test $metadata[1] = "file";
            __fish_complete_path $metadata[2];
        else if test $metadata[1] = "plain";
            echo $metadata[2];
        end;
    end;
end;

complete --no-files --command slewline --arguments "(_slewline_completion)"
