!> Opens a deck, steps it, and prints a channel. Build: gfortran pendulum.f90 $(pkg-config --cflags --libs limber-fortran)
program pendulum
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_library_stepped_run, only: stepped_run_type
   implicit none
   integer, parameter :: steps = 10
   type(stepped_run_type) :: run
   type(error_type), allocatable :: error
   real(wp), allocatable :: values(:)
   character(200) :: deck
   integer :: i
   call get_command_argument(1, deck)
   call run%open(trim(deck), error)
   if (.not. allocated(error)) then
      associate (model => run%scene%system%model)
         allocate (values(size(model%channels)))
         do i = 0, steps
            call run%advance(run%end*i/steps, error)
            if (.not. allocated(error)) call run%show(values, error)
            if (allocated(error)) exit
            print '(a, g0.6, 6a, g0.9)', 't = ', run%time, ' ', model%units%time, ': ', model%channels(1)%name, ' [', &
               & model%channels(1)%units//'] = ', values(1)
         end do
      end associate
   end if
   if (allocated(error)) print '(a)', error%message
   if (allocated(values)) deallocate (values)
end program pendulum
