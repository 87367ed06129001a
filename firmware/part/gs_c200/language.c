#include "language.h"

static const struct row *rows(const struct gsc *g)
{
    return g->part == GSC_C200S ? c200s_rows : c200_rows;
}

static const struct row *rows_end(const struct gsc *g)
{
    return rows(g) + (g->part == GSC_C200S ? C200S_ROWS : C200_ROWS);
}

static bool is_digit(uint8_t letter)
{
    return letter >= '0' && letter <= '9';
}

static bool is_sign(uint8_t letter)
{
    return letter == '+' || letter == '-';
}

static bool is_same_head(const struct row *one, const struct row *other)
{
    return one->head[0] == other->head[0] && one->head[1] == other->head[1];
}

/* ------------------------------------------------------------------------------------------------------------- read */
/* The rest of a string. */
struct rest {
    const uint8_t *at, *end;
};

static bool is_over(const struct rest *rest)
{
    return rest->at == rest->end;
}

/* A command without letters begins with the sign of its argument. */
static bool take_head(const struct row *row, struct rest *rest)
{
    const char *head = row->head;

    if (!*head)
        return !is_over(rest) && is_sign(*rest->at);
    for (; *head; head++, rest->at++)
        if (is_over(rest) || *rest->at != (uint8_t)*head)
            return false;
    return true;
}

static bool take_argument(const struct arg *arg, struct rest *rest, int64_t *value)
{
    const uint8_t *digits;
    bool has_sign = !is_over(rest) && is_sign(*rest->at) && arg->sign != UNSIGNED;
    bool is_negative = has_sign && *rest->at == '-';

    if (has_sign)
        rest->at++;
    if (arg->sign == SIGN_ALONE || arg->sign == SIGN_IF_ANY) { /* a missing sign means + */
        *value = is_negative ? -1 : 1;
        return has_sign || arg->sign == SIGN_IF_ANY;
    }
    if (arg->sign == WITH_SIGN && !has_sign) /* a move has no letters: its sign selects the row */
        return false;
    for (*value = 0, digits = rest->at; !is_over(rest) && is_digit(*rest->at); rest->at++)
        *value = *value * 10 + (*rest->at - '0');
    if (is_negative)
        *value = -*value;
    return rest->at > digits;
}

static bool take_tail(const struct row *row, struct rest *rest)
{
    if (!*row->tail)
        return true;
    if (is_over(rest) || (*rest->at != (uint8_t)row->tail[0] && *rest->at != (uint8_t)row->tail[1]))
        return false;
    rest->at++;
    return true;
}

/* Two arguments are separated by a comma, unless the first is only a sign. */
static bool take_arguments(const struct row *row, struct rest *rest, int64_t *values)
{
    for (uint8_t i = 0; i < row->args; i++) {
        if (i && row->arg[i - 1].sign != SIGN_ALONE && (is_over(rest) || *rest->at++ != ','))
            return false;
        if (!take_argument(&row->arg[i], rest, &values[i]))
            return false;
    }
    return take_tail(row, rest) && is_over(rest);
}

static bool is_allowed(const struct arg *arg, int64_t value)
{
    return value >= arg->low && value <= arg->high && (value != 0 || arg->sign != WITH_SIGN_BUT_0);
}

static bool are_allowed(const struct row *row, const int64_t *values)
{
    for (uint8_t i = 0; i < row->args; i++)
        if (!is_allowed(&row->arg[i], values[i]))
            return false;
    return true;
}

enum reading read_command(const struct gsc *g, const uint8_t *text, uint8_t length, struct command_line *found)
{
    const struct row *row, *first = 0;

    for (row = rows(g); row < rows_end(g); row++) {
        struct rest rest = {text, text + length};
        int64_t values[2] = {0, 0};

        if ((first && !is_same_head(first, row)) || !take_head(row, &rest))
            continue;
        if (row->command == FOREIGN)
            return IS_UNKNOWN;
        first = row;
        if (take_arguments(row, &rest, values) && are_allowed(row, values)) {
            *found = (struct command_line){row, {(int32_t)values[0], (int32_t)values[1]}};
            return IS_COMMAND;
        }
    }
    return first ? IS_WRONG_ARGUMENT : IS_UNKNOWN;
}

/* ------------------------------------------------------------------------------------------------------------ write */
uint8_t spell_number(int32_t number, bool has_plus, uint8_t *text)
{
    uint8_t digits[7], count = 0, length = 0;
    uint32_t rest = (uint32_t)(number < 0 ? -number : number);

    if (number < 0 || has_plus)
        text[length++] = number < 0 ? '-' : '+';
    do
        digits[count++] = (uint8_t)('0' + rest % 10);
    while (rest /= 10);
    while (count)
        text[length++] = digits[--count];
    return length;
}

uint8_t spell_instruction(const struct command_line *instruction, uint8_t *text)
{
    const struct row *row = instruction->row;
    uint8_t length = 0;

    for (const char *head = row->head; *head; head++)
        text[length++] = (uint8_t)*head;
    for (uint8_t i = 0; i < row->args; i++) {
        if (i && row->arg[i - 1].sign != SIGN_ALONE)
            text[length++] = ',';
        if (row->arg[i].sign == SIGN_ALONE)
            text[length++] = instruction->values[i] > 0 ? '+' : '-';
        else
            length = (uint8_t)(length +
                               spell_number(instruction->values[i], row->arg[i].sign != UNSIGNED, text + length));
    }
    if (*row->tail)
        text[length++] = (uint8_t)*row->tail;
    return length;
}

/* ------------------------------------------------------------------------------------------------ the program memory */
void pack_instruction(const struct command_line *instruction, uint8_t *bytes)
{
    const struct row *row = instruction->row;
    uint8_t at = 1;

    bytes[0] = row->code;
    for (uint8_t i = 0; i < row->args; i++) {
        uint32_t value = (uint32_t)instruction->values[i];

        if (!row->arg[i].size)
            bytes[0] = (uint8_t)(bytes[0] + value);
        for (uint8_t byte = 0; byte < row->arg[i].size; byte++, value >>= 8)
            bytes[at++] = (uint8_t)value;
    }
    while (at < row->size)
        bytes[at++] = 0;
}

static const struct row *row_of(const struct gsc *g, uint8_t code)
{
    for (const struct row *row = rows(g); row < rows_end(g); row++) {
        bool is_added = row->args && !row->arg[0].size; /* the first argument, to the opcode */

        if (row->size && (is_added ? code >= row->code : code == row->code))
            return row;
    }
    return 0;
}

static int32_t number_of(const struct arg *arg, const uint8_t *bytes)
{
    uint32_t value = 0, sign = 1U << (8 * arg->size - 1);

    for (uint8_t byte = arg->size; byte--;)
        value = value << 8 | bytes[byte];
    return arg->low < 0 && (value & sign) ? (int32_t)(value - sign) - (int32_t)sign : (int32_t)value;
}

bool unpack_instruction(const struct gsc *g, const uint8_t *bytes, uint8_t length, struct command_line *found)
{
    const struct row *row = length ? row_of(g, bytes[0]) : 0;
    uint8_t at = 1;

    if (!row || row->size > length)
        return false;
    found->row = row;
    for (uint8_t i = 0; i < row->args; i++) {
        found->values[i] = row->arg[i].size ? number_of(&row->arg[i], bytes + at) : bytes[0] - row->code;
        at = (uint8_t)(at + row->arg[i].size);
        if (!is_allowed(&row->arg[i], found->values[i]))
            return false;
    }
    return true;
}
