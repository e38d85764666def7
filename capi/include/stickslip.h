/* The C interface of stickslip: contacts, beams, mass-spring models and rigs from the text of a model file.
 *
 * Every function that returns a status can be called from any thread. A model is locked while a call runs: two threads may
 * use the same one, and different ones do not wait for each other. Whoever frees a model sees to it that nobody
 * uses it any more. All numbers are in SI units.
 *
 * Written by cbindgen: do not edit. Licence: MIT or Apache-2.0.
 */

#ifndef STICKSLIP_H
#define STICKSLIP_H

#include <stddef.h>
#include <stdint.h>

/*
 What a call came to.
 */
typedef enum {
  /*
   Done.
   */
  STICKSLIP_STATUS_OK = 0,
  /*
   Refused: an argument is wrong. The model is as before.
   */
  STICKSLIP_STATUS_REFUSED = 1,
  /*
   The step, the start or the tangent cannot be computed. The model is as before: a smaller step may succeed.
   */
  STICKSLIP_STATUS_FAILED = 2,
  /*
   An internal error. Nothing can be done with the model but to free it.
   */
  STICKSLIP_STATUS_BROKEN = 3,
} stickslip_status;

/*
 Which variables of a model.
 */
typedef enum {
  /*
   Given to every step.
   */
  STICKSLIP_KIND_INPUT = 0,
  /*
   Computed by every step.
   */
  STICKSLIP_KIND_OUTPUT = 1,
  /*
   Set before the start.
   */
  STICKSLIP_KIND_PARAMETER = 2,
} stickslip_kind;

/*
 A model that is being simulated.
 */
typedef struct stickslip_model stickslip_model;

/*
 A saved state of a model.
 */
typedef struct stickslip_state stickslip_state;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The version of the library, as "0.1.0".
 */
const char *stickslip_version(void);

/*
 Why the last call of this thread that failed did so: what, where, and what is allowed. "" before any failed.
 The text lives until the next call of this thread that fails.
 */
const char *stickslip_error_text(void);

/*
 Makes a model of `model_toml`, the text of a model file (UTF-8, ends with 0), and writes it to `*model`.
 It has to be started next.

 # Safety
 `model_toml` is NULL or a text, `model` NULL or a place.
 */
stickslip_status stickslip_create(const char *model_toml, stickslip_model **model);

/*
 Makes a second model that goes on as the first one would, and writes it to `*copy`. The two have nothing
 in common afterwards.

 # Safety
 `model` is NULL or a model, `copy` NULL or a place.
 */
stickslip_status stickslip_copy(const stickslip_model *model, stickslip_model **copy);

/*
 Frees a model; NULL is ignored. Names and units of its variables end with the last copy that shares
 them.

 # Safety
 `model` is NULL or a model that no thread uses now or later.
 */
void stickslip_free(stickslip_model *model);

/*
 Begins, or begins anew, at time 0 with the parameters as they were set: builds the model and writes the
 outputs at the start. A contact comes unstressed from displacement 0. `inputs` has a number for each
 input; NULL leaves them at the values the model file gives. `outputs` has room for each output, or is
 NULL. `tolerance` is the relative tolerance of the integration inside; 0 is 1e-6.

 # Safety
 `model` is NULL or a model; the arrays are NULL or as long as said.
 */
stickslip_status stickslip_start(stickslip_model *model,
                                 const double *inputs,
                                 double tolerance,
                                 double *outputs);

/*
 One step of `step` seconds, above 0. `inputs` has a number for each input, NULL leaves them as they are;
 of a contact, an oscillator and a pin rig they are those reached at the end of the step, on a straight
 line, of a beam they are held. `outputs`, with room for each output, receives those at the end; it may
 be NULL. Where the step fails or is refused the model is as before it.

 # Safety
 `model` is NULL or a model; the arrays are NULL or as long as said.
 */
stickslip_status stickslip_step(stickslip_model *model, const double *inputs, double step, double *outputs);

/*
 Writes the derivatives of the outputs at the end of the last step by the inputs given to that step (of a
 pin rig from differences, elsewhere exact): `tangent[i * inputs + j]` is that of output `i` by input
 `j`, in SI units. A whole number (`slip_state`) has 0. Before the first step they are those of the
 outputs at the start.

 # Safety
 `model` is NULL or a model; `tangent` is NULL or has room for outputs times inputs numbers.
 */
stickslip_status stickslip_tangent(stickslip_model *model, double *tangent);

/*
 Writes the end of the last step, in seconds since the start, to `*time`.

 # Safety
 `model` is NULL or a model, `time` NULL or a place.
 */
stickslip_status stickslip_time(const stickslip_model *model, double *time);

/*
 Saves the whole state of a model to `*state`. Where that is NULL a new state is made, otherwise the one
 there is used again, without new memory where it is of the same model.

 # Safety
 `model` is NULL or a model; `state` is NULL or a place with NULL or a state that no other thread uses
 now.
 */
stickslip_status stickslip_save(const stickslip_model *model, stickslip_state **state);

/*
 Makes a model go on where `state` was saved, by this model or another of the same model file. Parameters
 set for the next start stay as they are.

 # Safety
 `model` is NULL or a model; `state` is NULL or a state.
 */
stickslip_status stickslip_restore(stickslip_model *model, const stickslip_state *state);

/*
 Frees a state; NULL is ignored.

 # Safety
 `state` is NULL or a state that no thread uses now or later.
 */
void stickslip_state_free(stickslip_state *state);

/*
 Number of bytes that `stickslip_state_write` writes; 0 for NULL.

 # Safety
 `state` is NULL or a state.
 */
size_t stickslip_state_size(const stickslip_state *state);

/*
 Writes a state as bytes, the same on every platform, for a file or another process. `size` is what
 `stickslip_state_size` tells.

 # Safety
 `state` is NULL or a state; `bytes` is NULL or has room for `size` bytes.
 */
stickslip_status stickslip_state_write(const stickslip_state *state, uint8_t *bytes, size_t size);

/*
 Reads a state of `model` from bytes and writes a new state to `*state`. Bytes that are no state, changed
 ones and those of another model are refused.

 # Safety
 `model` is NULL or a model; `bytes` is NULL or has `size` bytes; `state` is NULL or a place.
 */
stickslip_status stickslip_state_read(const stickslip_model *model,
                                      const uint8_t *bytes,
                                      size_t size,
                                      stickslip_state **state);

/*
 The number of variables of a kind (`stickslip_kind`); 0 for NULL and unknown kinds.

 # Safety
 `model` is NULL or a model.
 */
size_t stickslip_variable_count(const stickslip_model *model, int kind);

/*
 The name of a variable, as "displacement"; it lives as long as the model. NULL where there is no such
 variable.

 # Safety
 `model` is NULL or a model.
 */
const char *stickslip_variable_name(const stickslip_model *model, int kind, size_t index);

/*
 The unit of a variable, as "N/m", SI without prefixes; it lives as long as the model. NULL where there
 is no such variable.

 # Safety
 `model` is NULL or a model.
 */
const char *stickslip_variable_unit(const stickslip_model *model, int kind, size_t index);

/*
 Writes to `*index` which variable of a kind is called `name`.

 # Safety
 `model` is NULL or a model, `name` NULL or a text, `index` NULL or a place.
 */
stickslip_status stickslip_variable_find(const stickslip_model *model,
                                         int kind,
                                         const char *name,
                                         size_t *index);

/*
 Sets a parameter for the next start.

 # Safety
 `model` is NULL or a model.
 */
stickslip_status stickslip_set_parameter(stickslip_model *model, size_t index, double value);

/*
 Writes a parameter, as the next start will have it, to `*value`.

 # Safety
 `model` is NULL or a model, `value` NULL or a place.
 */
stickslip_status stickslip_parameter(const stickslip_model *model, size_t index, double *value);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* STICKSLIP_H */
