"""Both ways into the CY545: what no readable page tells, or two tell differently.  Data only."""

from __future__ import annotations

from ...core.datasheet.quirk import Quirk as _Q

# fmt: off
SIDES = (
    # ----------------------------------------------------------------------------------------------------------- the bus
    _Q("CY545-UND-HS-SAMPLE", "ch.16, The Parallel Handshake", "the byte is taken as BUSY falls; one that changes before is told",
       "the host must hold it until then", "test_a_byte_that_changes_before_busy_falls_counts_as_it_is_then_and_is_told"),
    _Q("CY545-UND-HS-TIMING", "ch.16, The Parallel Handshake", "every answer takes 25 us at 12 MHz; options inferred.busy_end, inferred.output_delay, inferred.flow_lead",
       "one number is printed, without a crystal", "test_the_lines_of_one_byte_move_in_order_and_in_time"),
    _Q("CY545-UND-BUSY-SERIAL", "ch.16, The Parallel Handshake", "BUSY falls as an answer to IO_REQUEST alone, not for a command of the serial side",
       "a host that has lowered IO_REQUEST would take it for its answer", "test_busy_does_not_move_for_a_command_of_the_serial_side"),
    _Q("CY545-UND-TWO-SIDES", "ch.16", "the side that begins a command has the chip until its end; so has the bus from the empty handshake on while a program runs; any other FF begins nothing; the other side waits",
       "what is told of memory and host; with no program the FF is ignored, says the text", "test_the_side_that_begins_a_command_has_the_chip_until_its_end"),
    _Q("CY545-UND-STRING-FPL", "ch.16, The Parallel Handshake", "FPL rises with the last character of a string, and with each return in one",
       "the one ends the message, and of the other the text says so", "test_a_string_ends_fpl_with_its_last_character"),
    _Q("CY545-CON-FPL-EDGE", "ch.16, The Parallel Handshake against CY545B", "the CY545 raises FPL before BUSY falls for the last byte, the CY545B behind IO_REQUEST",
       "the later text is that of the later part", "test_fpl_ends_behind_the_request_of_the_last_byte_or_before_busy_answers_it"),
    _Q("CY545-CON-BINARY-FPL", "ch.16, The Parallel Handshake against CY545B", "in binary FPL rises behind every byte, in ASCII behind a message, on both parts",
       "the CY545B's text speaks of messages in ASCII", "test_in_binary_every_byte_has_its_own_fpl"),
    # ---------------------------------------------------------------------------------------------------- while a program runs
    _Q("CY545-CON-FIRST-HANDSHAKE", "ch.16, The Parallel Handshake against CY545B", "25 us hold for an idle chip and within a command; the first handshake waits for the command in work",
       "each sentence in its place", "test_the_first_handshake_is_answered_when_the_command_of_the_program_is_over"),
    _Q("CY545-UND-BUSY-PROGRAM", "ch.16, CY545B", "BUSY is high while a program of the CY545B runs; of the CY545 it stays low behind X over the bus",
       "the one takes commands, the other one none", "test_busy_is_low_while_a_program_of_the_cy545_runs_and_no_host_is_heard"),
    _Q("CY545-UND-IMM-POLL", "ch.16, CY545B", "before each command of the program the bus is looked at, then the serial side",
       "told: behind the command in work", "test_of_two_sides_that_ask_the_parallel_one_is_heard_first"),
    _Q("CY545-UND-IMM-SET", "ch.16, CY545B", "E, Q, X, Y, J, L, T and Z of a host are refused while a program runs, and told",
       "the program goes its own way", "test_commands_that_would_lead_a_program_elsewhere_are_refused"),
    _Q("CY545-UND-IMM-DRIVEN", "ch.16, CY545B", "a byte in the first handshake is taken as the letter, and told",
       "nothing is lost so", "test_a_letter_in_the_first_handshake_is_taken_and_told"),
    # ------------------------------------------------------------------------------------------------------ the serial side
    _Q("CY545-UND-BAUD-STRAP", "ch.16, The Serial Interface", "option fixed_baud; straps on IO_REQUEST and BUSY are not read",
       "the figure is missing", "test_a_fixed_rate_needs_no_carriage_returns"),
    _Q("CY545-UND-BAUD-ADAPT", "ch.16, The Serial Interface", "two returns one behind the other, within 3 percent of a standard rate; other crystals move the limits, 300 and 19,200 at 11 MHz, in proportion",
       "rates and crystal are named, nothing else", "test_which_rates_it_finds_at_which_crystal"),
    _Q("CY545-UND-SERIAL-FRAME", "not mentioned", "8 data bits, no parity, 1 stop bit; no echo, no prompt",
       "usual", "test_commands_come_in_on_rxd_and_answers_go_out_on_txd"),
    _Q("CY545-UND-SERIAL-OVERRUN", "ch.16, The Serial Interface", "of a fourth character the chip knows nothing; it is told",
       "three are kept", "test_three_characters_wait_while_the_chip_is_at_work_and_the_newest_is_lost"),
    _Q("CY545-UND-SERIAL-SILENT", "ch.16, The Serial Interface", "what is to be sent before a rate is known is lost, and told",
       "told: nothing is sent before the two returns", "test_a_reply_to_nobody_is_lost_and_told"),
    _Q("CY545-CON-CTS-IDLE", "ch.16, The Serial Interface against CY545B", "CTS is low while commands are read, high while they are carried out, and while the bus has the chip",
       "to read is not to execute", "test_cts_is_high_while_a_command_is_executed"),
)
