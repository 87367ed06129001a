"""The local bus of the CY545: what no readable page tells, or two tell differently.  Data only."""

from __future__ import annotations

from ...core.datasheet.quirk import Quirk as _Q

# fmt: off
LOCAL_BUS = (
    _Q("CY545-CON-XMEM-SEL-LATCH", "ch.16, External Memory, twice", "the fall of XMEM_SEL latches the high byte of the address, that of ALE the low one; the memory drives the bus only while RD is low",
       "XMEM_SEL selects the memory before the low byte and the data stand on the same bus", "test_the_address_goes_out_high_byte_first_and_the_chip_lets_go_of_the_bus_while_it_reads"),
    _Q("CY545-UND-TIMEOUT", "ch.16, External Memory", "a byte that reads back wrong is given up after 20 ms, is told, and the next one follows; options inferred.verify_timeout, .verify_poll",
       "EEPROMs of the time took up to 10 ms", "test_without_a_memory_a_byte_takes_the_whole_time_out_and_is_told"),
    _Q("CY545-UND-THUMB-ADDRESS", "ch.16, Thumbwheel Switch", "address = the low five bits of the command's letter, then three bits that count the digits from the left; a digit on DB0 to DB3, high is 1",
       "eight bits, another address for every digit of every command", "test_as_many_digits_as_the_width_asks_for_each_at_its_own_address"),
    _Q("CY545-UND-THUMB-RANGE", "not mentioned", "switches above the range: the low bits count, and it is told; a digit above 9 counts as what it is",
       "as with a number that is written", "test_switches_above_the_range_keep_the_low_bits_and_are_told"),
    _Q("CY545-UND-HP-COMMAND", "ch.4", "[ takes numbers up to the return, and a closing bracket may follow; if count and data differ the fewer count, which is told; in binary 5BH, count, address, how many, data",
       "as little as can be read", "test_data_for_the_display_may_end_in_a_bracket_and_the_fewer_count"),
    _Q("CY545-UND-HP-OUTPUT", "ch.16, HP LED Display", "strings and answers fill the addresses 38H to 3FH from the left, blanks behind; of a longer one the last eight characters are seen; the return of text is left out, a byte 0D of a binary value is not",
       "the characters of an HDSP-211x lie there; of a position the eight digits remain", "test_strings_and_replies_on_the_display"),
    _Q("CY545-UND-LCD", "ch.14", "to the LCD go the characters of the plain serial side; the part `lcd` takes X=00123 and a return for a parameter, all else for text",
       "the control codes of the CY325 are in no readable page", "test_parameters_stand_on_the_left_and_texts_on_the_right"),
)
# fmt: on
