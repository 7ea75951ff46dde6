!> The real kind of all numbers. Floor: base.
module limber_base_kinds
   use, intrinsic :: iso_fortran_env, only: real64, int64
   implicit none
   private
   public :: wp, long

   !> Working precision of every real in limber: IEEE double
   integer, parameter :: wp = real64
   !> Integers that count clock ticks or steps
   integer, parameter :: long = int64

end module limber_base_kinds
