!> Reductions that are kept for the runs of a sweep: each is found again as it was, and when there are too many, all are forgotten
!> and the next ones are kept.
program test_library
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_beam_reduction_cache, only: library_type
   use limber_beam_beam_mesh, only: displacement_field_type
   use limber_beam_reduced_body, only: reduced_type
   use testing, only: check, check_close, check_text, finish
   implicit none
   call test_many()
   call finish()

contains

   !> More than the 512 that there is room for.
   subroutine test_many()
      integer, parameter :: most = 512
      type(library_type) :: library
      integer :: i
      do i = 1, most
         call keep(library, i)
      end do
      do i = 1, most
         call check(has(library, i), 'all are there')
      end do
      call check(.not. has(library, most + 1), 'what was not kept is not there')
      call keep(library, most + 1)
      call check(has(library, most + 1), 'the next one is kept')
      do i = 1, most
         call check(.not. has(library, i), 'all others are forgotten')
      end do
      call keep(library, 7)
      call check(has(library, 7) .and. has(library, most + 1), 'what was forgotten can be kept again')
   end subroutine test_many

   !> Keeps a reduction that its number can be told from.
   subroutine keep(library, number)
      type(library_type), intent(inout) :: library
      integer, intent(in) :: number
      type(reduced_type) :: reduced
      type(displacement_field_type) :: field
      reduced%mass = number
      allocate (reduced%skew(2, 2), source=real(number, wp))
      allocate (reduced%rotary(0, 0), reduced%cubic(0, 0))
      call library%put('beam '//as_text(number), reduced, field, 'note '//as_text(number))
   end subroutine keep

   !> Whether a reduction is found, as it was.
   logical function has(library, number)
      type(library_type), intent(in) :: library
      integer, intent(in) :: number
      type(reduced_type) :: reduced
      type(displacement_field_type) :: field
      character(:), allocatable :: note
      note = ''
      call library%look_up('beam '//as_text(number), reduced, field, note, has)
      if (.not. has) return
      call check_close(reduced%mass, real(number, wp), 0.0_wp, 'its mass')
      call check_close(reduced%skew(2, 1), real(number, wp), 0.0_wp, 'its matrix')
      call check_text(note, 'note '//as_text(number), 'its note')
   end function has

end program test_library
