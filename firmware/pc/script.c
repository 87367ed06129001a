/* A board that executes a script from its input, and prints the changes of its pins and its line, with their ticks.
 *
 *     boot TICK LEVELS     its inputs have these levels, bit n input n
 *     frame TICK HEX       bytes are received, up to their zero, and processed at this tick
 *     inputs TICK LEVELS   it samples its inputs
 *     watch TICK           a round of its main loop checks the driver's current and the time since the last frame,
 *     silence TICK         and brakes
 *     run TICK             time passes
 *
 * It prints `step TICK DIRECTION EDGE`, `phases TICK LEVELS`, `outputs TICK LEVELS`, `enable TICK LEVEL` (-1: none) and
 * `sent HEX`.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "answers.h"
#include "commands.h"
#include "hal.h"
#include "inputs.h"
#include "line.h"
#include "outputs.h"
#include "rounds.h"
#include "stop_ramp.h"

static int shown_phases, shown_outputs, shown_enable = -1;

static void show(const char *name, int *shown, int value)
{
    if (*shown == value)
        return;
    *shown = value;
    printf("%s %" PRIu64 " %d\n", name, pc.now, value);
}

static void show_pins(void)
{
    show("phases", &shown_phases, pc.phases);
    show("outputs", &shown_outputs, pc.outputs);
    show("enable", &shown_enable, pc.drives_enable ? pc.enable : -1);
}

/* Do the work of a main loop round that has no instant of its own, and print the pins. */
static void go_round(void)
{
    send_events();
    refresh_lamps();
    refresh_hint();
    show_pins();
}

static void stepped(void)
{
    show_pins(); /* of the instant before */
    printf("step %" PRIu64 " %d %d\n", pc.now, pc.direction, !pc.is_dry);
}

static void show_line(void)
{
    size_t i;

    if (!pc.sent_length)
        return;
    printf("sent ");
    for (i = 0; i < pc.sent_length; i++)
        printf("%02x", pc.sent[i]);
    printf("\n");
    pc.sent_length = 0;
}

static void receive(const char *hex)
{
    unsigned byte;
    int8_t verdict;

    pc.received_head = pc.received_tail = 0;
    for (; sscanf(hex, "%2x", &byte) == 1; hex += 2)
        pc.received[pc.received_head++] = (uint8_t)byte;
    while ((verdict = listen()))
        if (verdict > 0)
            take_frame();
        else
            take_damage();
}

int main(void)
{
    char verb[16], text[1024];
    uint64_t tick;

    while (scanf("%15s %" SCNu64, verb, &tick) == 2) {
        /* Pins change with each match, and are printed with their tick. */
        while (pc.match <= tick) {
            pc_run(pc.match, stepped);
            go_round();
        }
        pc_run(tick, stepped);
        if (!strcmp(verb, "frame") && scanf("%1023s", text) == 1) {
            receive(text);
        } else if (!strcmp(verb, "boot") || !strcmp(verb, "inputs")) {
            unsigned levels;

            if (scanf("%u", &levels) != 1)
                return 2;
            pc.levels = (uint8_t)levels;
            if (verb[0] == 'b')
                power_up();
            else
                look();
        } else if (!strcmp(verb, "watch")) {
            watch();
        } else if (!strcmp(verb, "silence")) {
            brake_if_silent();
        } else if (strcmp(verb, "run")) {
            return 2;
        }
        go_round();
        show_line();
    }
    return 0;
}
