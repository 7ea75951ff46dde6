!> Run as one of many. Floor: commands.
module limber_commands_batch
   use limber_base_kinds, only: wp
   use limber_scene_interruption, only: request_type
   use limber_deck_parameters, only: override_type
   use limber_beam_reduction_cache, only: library_type
   implicit none
   private
   public :: batch_type

   !> What a run of many is given, and what it leaves behind
   type :: batch_type
      !> Values of parameters in place of those of the deck
      type(override_type), allocatable :: overrides(:)
      !> Reductions of beams that earlier runs have made
      type(library_type) :: library
      !> Whether the history is forgotten; whether the usual scalars are taken of a deck that asks for none
      logical :: unkept = .false., usual_scalars = .false.
      !> CPU time after which the run is given up [s]
      real(wp) :: limit = huge(1.0_wp)
      !> Largest estimated error of a channel relative to its magnitude, if the deck asks for that; else negative
      real(wp) :: error = -1.0_wp
      !> CPU seconds of the run, all included; its warnings
      real(wp) :: cpu = 0.0_wp
      character(:), allocatable :: warnings
      !> Scalars (scalars)
      real(wp), allocatable :: scalars(:)
      !> Whether it can be interrupted and go on, and what is asked for then
      logical :: guarded = .false.
      type(request_type) :: request
   end type batch_type

end module limber_commands_batch
