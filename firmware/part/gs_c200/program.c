#include "program.h"

#include "motion.h"
#include "pins.h"
#include "profile.h"
#include "storage.h"

enum phase {
    NOTHING_RUNS,
    BEGINS_HOMING,   /* together with other events of this instant */
    FETCHING,        /* the time of an instruction passes, then it takes effect */
    REPEATING,       /* U: that time passes once more before the first instruction */
    PAUSING,         /* D, or the RESET pulse of I */
    WAITING,         /* W */
    MOVING,
    KILLED           /* until the pulse in progress is over */
};

/* -------------------------------------------------------------------------------------------------- start and end */
bool is_running(const struct gsc *g)
{
    return g->program.phase != NOTHING_RUNS;
}

static void begin_run(struct gsc *g)
{
    g->program.next = 0;
    g->program.is_ending = false;
    g->program.until = 0;
    g->program.has_loop = false;
}

void end_run(struct gsc *g)
{
    end_motion(g);
    g->program.phase = NOTHING_RUNS;
    end_work(g, PROGRAM_WORK);
}

gsc_time kill_run(struct gsc *g)
{
    stop_timer(g, GSC_RUN_TIMER);
    stop_timer(g, GSC_WATCH_TIMER);
    g->program.phase = KILLED;
    return kill_motion(g);
}

void come_to_rest(struct gsc *g)
{
    g->program.is_ending = true;
    g->motion.is_stop = true;
}

static void pass(struct gsc *g, enum phase phase, gsc_time delay_ps)
{
    g->program.phase = phase;
    start_timer(g, GSC_RUN_TIMER, delay_ps);
}

/* U at location 0 has found its input high; repeat the program while it is high (GSC-UND-U-FIRST). */
static bool is_repeated(const struct gsc *g)
{
    return g->program.until && is_user_input_high(g, g->program.until);
}

/* Continue with the next instruction, or after the last as U requires.  A jump into an instruction, or past the last
   one, ends the program (GSC-UND-JUMP-INSIDE, GSC-UND-JUMP-PAST). */
static void go_on(struct gsc *g)
{
    uint8_t at = g->program.next;

    if (g->program.is_ending) {
        end_run(g);
    } else if (at >= g->program.size) {
        if (is_repeated(g)) {
            g->program.next = 0;
            pass(g, REPEATING, INSTRUCTION_PS);
        } else {
            end_run(g);
        }
    } else if (is_start_of_instruction(g, at)) {
        g->program.at = at;
        pass(g, FETCHING, INSTRUCTION_PS);
    } else {
        end_run(g);
    }
}

void run_program(struct gsc *g)
{
    begin_work(g, PROGRAM_WORK);
    begin_run(g);
    go_on(g);
}

void run_homing(struct gsc *g, int8_t direction, bool runs_program_after)
{
    begin_work(g, PROGRAM_WORK);
    g->program.phase = BEGINS_HOMING;
    g->program.runs_on_after = runs_program_after;
    g->motion.direction = direction;
}

/* A homing sent by the host erases the program of a GS-C200 (command H). */
static void end_homing(struct gsc *g)
{
    if (g->program.runs_on_after) {
        run_program(g);
        return;
    }
    if (g->part == GSC_C200)
        g->program.size = 0;
    end_run(g);
}

/* ------------------------------------------------------------------------------------------------------------ motions */
/* Each returns whether the instruction continues, because a motion has begun. */
static bool overflow(struct gsc *g)
{
    g->registers.is_over = g->program.is_ending = true;
    return false;
}

static bool is_ready_to_move(struct gsc *g)
{
    bool is_ready = g->registers.start_stop && g->registers.top_speed && g->registers.ramp;

    g->program.is_ending = !is_ready;
    return is_ready;
}

static bool move_by(struct gsc *g, int32_t steps)
{
    int8_t direction = steps > 0 ? 1 : -1;
    uint32_t number = (uint32_t)(steps > 0 ? steps : -steps);

    if (!steps || !is_ready_to_move(g))
        return false;
    if (room_ahead(g, direction) < number)
        return overflow(g);
    plan_move(g, number);
    begin_motion(g, direction, false);
    return true;
}

/* The input is sampled once per instruction time (GSC-UND-GX-STOP). */
static bool run_endless(struct gsc *g, int8_t direction, uint8_t watched)
{
    uint32_t limit = room_ahead(g, direction);

    if (!is_ready_to_move(g) || (watched && !is_user_input_high(g, watched)))
        return false;
    if (!limit)
        return overflow(g);
    plan_endless(g, limit);
    begin_motion(g, direction, true);
    g->program.watched = watched;
    if (watched)
        start_timer(g, GSC_WATCH_TIMER, INSTRUCTION_PS);
    return true;
}

void watch_timed(struct gsc *g)
{
    if (is_user_input_high(g, g->program.watched))
        start_timer(g, GSC_WATCH_TIMER, INSTRUCTION_PS);
    else
        g->motion.is_stop = true;
}

static void end_of_motion(struct gsc *g)
{
    stop_timer(g, GSC_WATCH_TIMER);
    if (g->motion.homing) {
        end_homing(g);
        return;
    }
    if (g->motion.is_endless && !room_ahead(g, g->motion.direction) && !g->motion.is_stopped)
        overflow(g);
    go_on(g);
}

/* ------------------------------------------------------------------------------------------- the other instructions */
bool initialize_module(struct gsc *g, int32_t what)
{
    if (what & 2) {
        set_pin(g, GSC_UO1, false);
        set_pin(g, GSC_UO2, false);
        set_pin(g, GSC_UO3, false);
    }
    if (!(what & 1))
        return false;
    g->position = 0;
    pulse_reset(g);
    return true;
}

static void set_output(struct gsc *g, int32_t number, bool is_high)
{
    set_pin(g, (enum gsc_pin)(GSC_UO1 + number - 1), is_high);
}

/* At location 0 the input is tested again at the end of the program; elsewhere once. */
static void repeat_until(struct gsc *g, uint8_t input, uint8_t size)
{
    bool is_on = is_user_input_high(g, input);

    if (g->program.next == size)
        g->program.until = is_on ? input : 0;
    else if (is_on)
        g->program.next = 0;
}

/* One start and one count: GSC-UND-LOOP-NEST, GSC-UND-LOOP-JC. */
static void begin_loop(struct gsc *g, uint8_t at)
{
    g->program.has_loop = true;
    g->program.loop = at;
    g->program.passes = 0;
}

static void end_loop(struct gsc *g, int32_t passes)
{
    if (!g->program.has_loop)
        begin_loop(g, 0);
    g->program.passes++;
    if (g->program.passes < passes)
        g->program.next = g->program.loop;
    else
        g->program.has_loop = false;
}

static uint8_t user_inputs(const struct gsc *g)
{
    return (uint8_t)(g->inputs / GSC_UI1 & 7);
}

static void wait_for_input(struct gsc *g)
{
    if (is_user_input_high(g, g->program.waits_for))
        go_on(g);
    else
        pass(g, WAITING, INSTRUCTION_PS);
}

/* Execute an instruction whose time has passed. */
static void act(struct gsc *g)
{
    struct command_line found;
    int32_t first, second;
    bool is_moving = false;

    instruction_at(g, g->program.at, &found); /* the program does not change while it runs */
    first = found.values[0], second = found.values[1];
    g->program.next = (uint8_t)(g->program.at + found.row->size);
    switch ((enum command)found.row->command) {
    case ACTIVATE: set_output(g, first, true); break;
    case CLEAR: set_output(g, first, false); break;
    case DELAY: pass(g, PAUSING, (uint32_t)first * DELAY_UNIT_PS); return;
    case WAIT: g->program.waits_for = (uint8_t)first; wait_for_input(g); return;
    case UNTIL: repeat_until(g, (uint8_t)first, found.row->size); break;
    case LOOP_START: begin_loop(g, g->program.next); break;
    case LOOP: end_loop(g, first); break;
    case JUMP: g->program.next = (uint8_t)first; break;
    case JUMP_ON:
        if (user_inputs(g) == first)
            g->program.next = (uint8_t)second;
        break;
    case START_STOP: g->registers.start_stop = (uint16_t)first; break;
    case TOP_SPEED: g->registers.top_speed = (uint16_t)first; break;
    case RAMP: g->registers.ramp = (uint16_t)first; break;
    case MOVE: is_moving = move_by(g, first); break;
    case GOTO: is_moving = move_by(g, first - g->position); break;
    case VELOCITY: is_moving = run_endless(g, (int8_t)first, 0); break;
    case CONTROLLED_VELOCITY: is_moving = run_endless(g, (int8_t)first, (uint8_t)second); break;
    case FORCE: g->position = first; break;
    case INITIALIZE:
        if (initialize_module(g, first)) {
            pass(g, PAUSING, RESET_PS);
            return;
        }
        break;
    default: break; /* the others are never stored */
    }
    if (is_moving)
        g->program.phase = MOVING;
    else
        go_on(g);
}

/* ------------------------------------------------------------------------------------------------------------- timers */
void run_timed(struct gsc *g)
{
    switch ((enum phase)g->program.phase) {
    case FETCHING: act(g); break;
    case REPEATING:
    case PAUSING: go_on(g); break;
    case WAITING: wait_for_input(g); break;
    case MOVING:
        if (motion_timed(g))
            end_of_motion(g);
        break;
    case NOTHING_RUNS:
    case BEGINS_HOMING:
    case KILLED: break;
    }
}

void run_settled(struct gsc *g)
{
    bool is_over = false;

    if (g->program.phase == BEGINS_HOMING) {
        g->program.phase = MOVING;
        is_over = begin_homing(g, g->motion.direction, homing_speed(g));
    } else if (g->program.phase == MOVING) {
        is_over = motion_settled(g);
    }
    if (is_over)
        end_of_motion(g);
}
