!> What tests of interrupted runs share: a deck run whole and in pieces, and all that their two files hold compared bit for bit.
module pieces
   use hdf5, only: hid_t, hsize_t
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, status_interrupted
   use limber_scene_interruption, only: request_type
   use limber_commands_run, only: run_deck
   use limber_base_text, only: as_text
   use limber_output_hdf5, only: open_file, close_file
   use limber_output_hdf5_read, only: dataset_shape, list_members, longest_name, read_attribute, read_dataset
   use runs, only: change_deck
   use testing, only: check, check_no_error
   implicit none
   private
   public :: compare_pieces, compare_files

   !> Attributes of /run that are the same for the same bits
   character(*), parameter :: numbers(*) = [character(20) :: 'complete', 'steps', 'rejected_steps', 'failed_projections', &
      & 'right_hand_sides', 'jacobians', 'factorisations', 'highest_order', 'samples', 'time_reached', 'smallest_step', &
      & 'largest_step', 'position_residual', 'velocity_residual', 'first_energy', 'last_energy', 'work', 'largest_energy', &
      & 'energy_imbalance']

contains

   !> Runs a deck with two texts exchanged whole, and in pieces of some steps.
   subroutine compare_pieces(name, results, parts, old_1, new_1, old_2, new_2)
      !> Name of a deck in input; the file for the results
      character(*), intent(in) :: name, results
      !> How many, at the least
      integer, intent(in) :: parts
      !> Texts that occur in the deck, and what stands for them
      character(*), intent(in) :: old_1, new_1, old_2, new_2
      character(240) :: old(2), new(2)
      type(request_type) :: request
      type(error_type), allocatable :: error
      character(:), allocatable :: report, deck, other, title
      integer :: i
      old(1) = old_1
      old(2) = old_2
      new(1) = new_1
      new(2) = new_2
      deck = results//'.inp'
      other = results//'.pieces.h5'
      title = name//', '//trim(new_2)
      call change_deck('../input/'//name//'.inp', deck, old, new)
      call run_deck(deck, results, .true., .true., report, error)
      call check_no_error(error, title)
      if (allocated(error)) return
      request%stop_after = 1 + steps_of(results)/parts
      call run_deck(deck, other, .true., .true., report, error, request=request)
      request%restart = .true.
      do i = 1, 1000
         if (.not. allocated(error)) exit
         if (error%status /= status_interrupted) exit
         deallocate (error)
         call run_deck(deck, other, .false., .true., report, error, request=request)
      end do
      call check_no_error(error, title//': in pieces')
      call check(i >= parts, title//': goes on '//as_text(i - 1)//' times')
      if (.not. allocated(error)) call compare_files(results, other, title)
   end subroutine compare_pieces

   integer(long) function steps_of(results) result(steps)
      character(*), intent(in) :: results
      type(error_type), allocatable :: error
      integer(hid_t) :: file
      real(wp) :: number
      call open_file(results, file, error)
      if (.not. allocated(error)) call read_attribute(file, '/run', 'steps', number, error)
      call check_no_error(error, results)
      call close_file(results, file, error)
      steps = nint(number, long)
   end function steps_of

   !> Compares all datasets of two files, and what the runs counted.
   subroutine compare_files(results, other, title)
      character(*), intent(in) :: results, other, title
      type(error_type), allocatable :: error
      integer(hid_t) :: a, b
      real(wp) :: x, y
      integer :: i
      call open_file(results, a, error)
      call check_no_error(error, title)
      call open_file(other, b, error)
      call check_no_error(error, title)
      call compare_group(a, b, '', title)
      do i = 1, size(numbers)
         call read_attribute(a, '/run', trim(numbers(i)), x, error)
         if (.not. allocated(error)) call read_attribute(b, '/run', trim(numbers(i)), y, error)
         call check_no_error(error, title//': '//trim(numbers(i)))
         if (allocated(error)) cycle
         call check(same(x, y), title//': '//trim(numbers(i))//' '//as_text(y, 17)//' for '//as_text(x, 17))
      end do
      call close_file(results, a, error)
      call close_file(other, b, error)
   end subroutine compare_files

   recursive subroutine compare_group(a, b, group, title)
      integer(hid_t), intent(in) :: a, b
      character(*), intent(in) :: group, title
      character(longest_name), allocatable :: names(:), others(:)
      type(error_type), allocatable :: error
      integer(hsize_t), allocatable :: extent(:)
      character(1024) :: path
      integer :: i
      call list_members(a, group//'/', names, error)
      call check_no_error(error, title//': '//group)
      call list_members(b, group//'/', others, error)
      call check_no_error(error, title//': '//group)
      call check(size(names) == size(others), title//': members of '//group)
      do i = 1, size(names)
         path = group//'/'//trim(names(i))
         call dataset_shape(a, trim(path), extent, error)
         if (allocated(error)) then
            call compare_group(a, b, trim(path), title)
         else
            call compare_dataset(a, b, trim(path), size(extent), title)
         end if
      end do
   end subroutine compare_group

   !> Compares two datasets: numbers, or texts.
   subroutine compare_dataset(a, b, path, rank, title)
      integer(hid_t), intent(in) :: a, b
      character(*), intent(in) :: path, title
      integer, intent(in) :: rank
      type(error_type), allocatable :: error
      real(wp), allocatable :: x(:), y(:), xx(:, :), yy(:, :)
      character(:), allocatable :: text, other
      select case (rank)
      case (0)
         call read_dataset(a, path, text, error)
         if (.not. allocated(error)) call read_dataset(b, path, other, error)
         if (.not. allocated(error)) call check(text == other, title//': '//path//': '//other)
      case (1)
         call read_dataset(a, path, x, error)
         if (.not. allocated(error)) call read_dataset(b, path, y, error)
         if (allocated(error)) then
            call check_no_error(error, title//': '//path)
         else if (size(x) /= size(y)) then
            call check(.false., title//': '//path//' has '//as_text(size(y))//' for '//as_text(size(x)))
         else
            call check(all(same(x, y)), title//': '//path//' off by '//as_text(maxval(abs(x - y)), 3))
         end if
      case default
         call read_dataset(a, path, xx, error)
         if (.not. allocated(error)) call read_dataset(b, path, yy, error)
         if (allocated(error)) then
            call check_no_error(error, title//': '//path)
         else if (any(shape(xx) /= shape(yy))) then
            call check(.false., title//': shape of '//path)
         else
            call check(all(same(xx, yy)), title//': '//path//' off by '//as_text(maxval(abs(xx - yy)), 3))
         end if
      end select
      call check_no_error(error, title//': '//path)
   end subroutine compare_dataset

   !> Whether two numbers have the same bits.
   elemental logical function same(x, y)
      real(wp), intent(in) :: x, y
      same = transfer(x, 1_long) == transfer(y, 1_long)
   end function same

end module pieces
